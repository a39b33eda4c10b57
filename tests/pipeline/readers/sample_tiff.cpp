// Separate from the other formats, because libtiff's names conflict with libjpeg's.
#include <tiffio.h>

#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

std::size_t row_bytes(int width, const TiffKind& kind) {
    return (static_cast<std::size_t>(width) * (kind.planes ? 1 : kind.samples) * kind.bits + 7) / 8;
}

// Writes tiles of whole bytes per pixel, the only kind that the tests need.
void write_tiles(TIFF* tiff, int width, int height, const Bytes& rows, const TiffKind& kind, int plane) {
    const std::size_t pixel = static_cast<std::size_t>(kind.planes ? 1 : kind.samples) * kind.bits / 8;
    const std::size_t stride = row_bytes(width, kind);
    for (int top = 0; top < height; top += kind.tile)
        for (int left = 0; left < width; left += kind.tile) {
            Bytes tile(pixel * kind.tile * kind.tile, 0);
            for (int y = 0; y < kind.tile && top + y < height; ++y)
                for (int x = 0; x < kind.tile && left + x < width; ++x) {
                    const std::size_t from = stride * (static_cast<std::size_t>(plane) * height + top + y);
                    std::copy_n(rows.data() + from + pixel * (left + x), pixel,
                                tile.data() + pixel * (static_cast<std::size_t>(y) * kind.tile + x));
                }
            TIFFWriteTile(tiff, tile.data(), left, top, 0, static_cast<std::uint16_t>(plane));
        }
}

}  // namespace

Bytes make_tiff(int width, int height, const Bytes& rows, const TiffKind& kind) {
    const Folder folder;
    const std::filesystem::path path = folder.path() / "made.tif";
    TIFF* tiff = TIFFOpen(path.c_str(), kind.big_endian ? "wb" : "wl");
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, kind.samples);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, kind.bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, kind.format);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, kind.photometric);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, kind.compression);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, kind.planes ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_ORIENTATION, kind.orientation);
    if (!kind.profile.empty())
        TIFFSetField(tiff, TIFFTAG_ICCPROFILE, static_cast<int>(kind.profile.size()), kind.profile.data());
    if (!kind.nodata.empty()) {
        constexpr std::uint32_t tag = 42113;
        const TIFFFieldInfo field = {tag,          -1, -1, TIFF_ASCII,
                                     FIELD_CUSTOM, 1,  0,  const_cast<char*>("GDALNoData")};
        TIFFMergeFieldInfo(tiff, &field, 1);
        TIFFSetField(tiff, tag, kind.nodata.c_str());
    }
    const int colours = kind.photometric == PHOTOMETRIC_RGB         ? 3
                        : kind.photometric == PHOTOMETRIC_SEPARATED ? 4
                                                                    : 1;
    if (kind.samples > colours) {
        const std::vector<std::uint16_t> extra(kind.samples - colours, EXTRASAMPLE_UNASSALPHA);
        TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, static_cast<int>(extra.size()), extra.data());
    }
    if (kind.photometric == PHOTOMETRIC_PALETTE) {
        std::vector<std::uint16_t> red(1 << kind.bits), green(red), blue(red);
        for (std::size_t i = 0; i < red.size(); ++i) {
            red[i] = static_cast<std::uint16_t>(i * 257);
            green[i] = static_cast<std::uint16_t>(65535 - i * 257);
            blue[i] = 257 * 7;
        }
        TIFFSetField(tiff, TIFFTAG_COLORMAP, red.data(), green.data(), blue.data());
    }
    if (kind.tile > 0) {
        TIFFSetField(tiff, TIFFTAG_TILEWIDTH, kind.tile);
        TIFFSetField(tiff, TIFFTAG_TILELENGTH, kind.tile);
    } else {
        TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 2);
    }
    const int planes = kind.planes ? kind.samples : 1;
    const std::size_t stride = row_bytes(width, kind);
    for (int plane = 0; plane < planes; ++plane) {
        if (kind.tile > 0) {
            write_tiles(tiff, width, height, rows, kind, plane);
            continue;
        }
        for (int y = 0; y < height; ++y) {
            Bytes row(rows.begin() + stride * (static_cast<std::size_t>(plane) * height + y),
                      rows.begin() + stride * (static_cast<std::size_t>(plane) * height + y + 1));
            TIFFWriteScanline(tiff, row.data(), y, static_cast<std::uint16_t>(plane));
        }
    }
    TIFFClose(tiff);
    return read_bytes(path);
}

}  // namespace hexrelief::readers
