// Reads TIFF by libtiff: the first picture of the file. Grey and RGB samples are read as stored, everything
// else (palettes, YCbCr, CMYK) by libtiff's own conversion to 8-bit RGB. Pixels are as stored, whatever the
// orientation tag says.
#include <memory>

#include "pipeline/readers/codecs.h"
#include "pipeline/readers/tiff/tiff_file.h"

namespace hexrelief::readers::codec {
namespace {

TiffSource source_of(const SourceFile& file) {
    return {file.path, file.size(),
            [&file](auto at, void* to, std::size_t count) { return file.read_at(at, to, count) == count; }};
}

// Checks the file's length before memory is allocated, for compressions whose best ratio is known.
void check_promise(const TiffLayout& layout, const SourceFile& file) {
    const unsigned long long bytes =
        layout.row_bytes() * layout.height * (layout.planes ? layout.channels() : 1);
    switch (layout.compression) {
        case COMPRESSION_NONE:
            return check_length(file, bytes, 1);
        case COMPRESSION_PACKBITS:
            return check_length(file, bytes, 128);
        case COMPRESSION_LZW:
        case COMPRESSION_DEFLATE:
        case COMPRESSION_ADOBE_DEFLATE:
            return check_length(file, bytes, 4096);
        default:
            return;
    }
}

// Decodes the first strip or tile into untouched memory if it is large, because libtiff's conversion clears
// the memory of a whole strip or tile before it looks at the file.
void try_first_part(TIFF* tiff, const TiffSource& source) {
    constexpr tmsize_t much = 16 << 20, most = static_cast<tmsize_t>(1) << 33;
    const bool tiled = TIFFIsTiled(tiff);
    const tmsize_t bytes = tiled ? TIFFTileSize(tiff) : TIFFStripSize(tiff);
    if (bytes <= much) return;
    if (bytes > most) refuse(source.path, "malformed TIFF: impossible strip size; export it again");
    const std::unique_ptr<std::uint8_t[]> part(new std::uint8_t[static_cast<std::size_t>(bytes)]);
    if ((tiled ? TIFFReadEncodedTile(tiff, 0, part.get(), bytes)
               : TIFFReadEncodedStrip(tiff, 0, part.get(), bytes)) < 0)
        refuse_malformed(source);
}

Raster read_converted(TIFF* tiff, const TiffLayout& layout, TiffSource& source) {
    char reason[1024] = "";
    if (!TIFFRGBAImageOK(tiff, reason))
        refuse(source.path,
               std::string("TIFF variant not supported (") + reason + "); save it as grey or RGB");
    try_first_part(tiff, source);
    // Asking for the orientation that the file has makes libtiff leave the rows as they are.
    std::uint16_t orientation = ORIENTATION_TOPLEFT;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_ORIENTATION, &orientation);
    const std::size_t pixels = static_cast<std::size_t>(layout.width) * layout.height;
    // Not touched before it is decoded, so that a header without samples costs no memory.
    const std::unique_ptr<std::uint32_t[]> packed(new std::uint32_t[pixels]);
    if (!TIFFReadRGBAImageOriented(tiff, layout.width, layout.height, packed.get(), orientation, 1))
        refuse_malformed(source);
    std::vector<std::uint8_t> samples(pixels * 3);
    for (std::size_t i = 0; i < pixels; ++i) {
        samples[3 * i] = static_cast<std::uint8_t>(TIFFGetR(packed[i]));
        samples[3 * i + 1] = static_cast<std::uint8_t>(TIFFGetG(packed[i]));
        samples[3 * i + 2] = static_cast<std::uint8_t>(TIFFGetB(packed[i]));
    }
    Raster raster{
        static_cast<int>(layout.width), static_cast<int>(layout.height), 3, 255, kNoData, std::move(samples)};
    raster.profile = profile_of(tiff);
    return raster;
}

}  // namespace

FileDescription describe_tiff(const SourceFile& file) {
    TiffSource source = source_of(file);
    const TiffHandle tiff = open_tiff(source);
    const TiffLayout layout = read_layout(tiff.get(), source);
    check_size(file, layout.width, layout.height);
    const bool palette = layout.photometric == PHOTOMETRIC_PALETTE;
    return {"tiff",
            static_cast<int>(layout.width),
            static_cast<int>(layout.height),
            palette ? 3 : layout.samples,
            palette ? 8 : layout.bits,
            layout.format == SAMPLEFORMAT_IEEEFP};
}

Raster decode_tiff(const SourceFile& file) {
    TiffSource source = source_of(file);
    const TiffHandle tiff = open_tiff(source);
    const TiffLayout layout = read_layout(tiff.get(), source);
    check_size(file, layout.width, layout.height);
    check_promise(layout, file);
    if (!stored_plainly(layout)) return read_converted(tiff.get(), layout, source);
    Raster raster = read_plainly(tiff.get(), layout, source, {0, 0, layout.width, layout.height});
    if (layout.alpha) split_alpha(raster);
    return raster;
}

}  // namespace hexrelief::readers::codec
