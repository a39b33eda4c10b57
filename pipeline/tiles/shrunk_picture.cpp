#include "pipeline/tiles/shrunk_picture.h"

#include <algorithm>

#include "pipeline/data/shrink.h"

namespace hexrelief::tiles {

Image shrunk_picture(const readers::PictureWindows& picture, const mesh_tiles::MapRect& part, int by) {
    Image out{0, 0, picture.channels(), {}};
    const int band_rows = std::max(by, (1 << 24) / std::max(1, part.width) / by * by);
    for (int y = 0; y < part.height; y += band_rows) {
        const Image band =
            shrunk(picture.read(part.x, part.y + y, part.width, std::min(band_rows, part.height - y)), by);
        out.width = band.width;
        out.height += band.height;
        out.pixels.insert(out.pixels.end(), band.pixels.begin(), band.pixels.end());
    }
    return out;
}

}  // namespace hexrelief::tiles
