// Reads binary PGM (P5) and PPM (P6), one or two bytes per sample, big endian.
#include <algorithm>

#include "pipeline/readers/codecs.h"
#include "pipeline/readers/netpbm_header.h"

namespace hexrelief::readers::codec {

PnmHeader read_pnm_header(const SourceFile& source, NetpbmHeader& header) {
    PnmHeader pnm{};
    pnm.channels = source.bytes.at(1) == '6' ? 3 : 1;
    pnm.width = header.next_number("width");
    pnm.height = header.next_number("height");
    pnm.max_value = header.next_number("maxval");
    if (pnm.max_value < 1 || pnm.max_value > 65535) {
        refuse(source.path, "its maxval is " + std::to_string(pnm.max_value) +
                                "; it must lie in 1..65535, export it again");
    }
    return pnm;
}

FileDescription describe_pnm(const SourceFile& source) {
    NetpbmHeader header(source);
    const PnmHeader pnm = read_pnm_header(source, header);
    check_size(source, pnm.width, pnm.height);
    return {pnm.channels == 3 ? "ppm" : "pgm", static_cast<int>(pnm.width), static_cast<int>(pnm.height),
            pnm.channels, pnm.max_value > 255 ? 16 : 8};
}

Raster decode_pnm(const SourceFile& source) {
    NetpbmHeader header(source);
    const PnmHeader pnm = read_pnm_header(source, header);
    check_size(source, pnm.width, pnm.height);
    const bool wide = pnm.max_value > 255;
    const std::size_t count = static_cast<std::size_t>(pnm.width) * pnm.height * pnm.channels;
    const std::uint8_t* from = source.bytes.data() + header.samples_at(count * (wide ? 2 : 1));

    Raster raster;
    raster.width = static_cast<int>(pnm.width);
    raster.height = static_cast<int>(pnm.height);
    raster.channels = pnm.channels;
    raster.max_value = pnm.max_value;
    if (wide) {
        std::vector<std::uint16_t> samples(count);
        for (std::size_t i = 0; i < count; ++i) {
            samples[i] = static_cast<std::uint16_t>(from[2 * i] << 8 | from[2 * i + 1]);
        }
        raster.samples = std::move(samples);
    } else {
        raster.samples = std::vector<std::uint8_t>(from, from + count);
    }
    return raster;
}

}  // namespace hexrelief::readers::codec
