#include <algorithm>
#include <bit>
#include <mutex>

#include "pipeline/readers/tiff/tiff_file.h"
#include "pipeline/readers/windows/window_source.h"

namespace hexrelief::readers {
namespace {

// A handle of libtiff, which only one thread may use at a time.
struct OpenTiff {
    explicit OpenTiff(const MapFile& file)
        : source{file.path(), file.bytes(),
                 [&file](auto at, void* to, std::size_t count) { return file.copy(at, to, count); }},
          handle(codec::open_tiff(source)) {}
    codec::TiffSource source;
    codec::TiffHandle handle;
};

MapSample sample_of(const codec::TiffLayout& layout) {
    if (layout.format == SAMPLEFORMAT_IEEEFP) return MapSample::float32;
    return layout.bits == 16 ? MapSample::uint16 : MapSample::uint8;
}

class TiffWindows : public WindowSource {
  public:
    TiffWindows(std::shared_ptr<const MapFile> file, std::unique_ptr<OpenTiff> tiff,
                const codec::TiffLayout& layout)
        : file_(std::move(file)), layout_(layout) {
        width = static_cast<int>(layout.width);
        height = static_cast<int>(layout.height);
        channels = layout.channels() - layout.alpha;
        has_alpha = layout.alpha;
        sample = sample_of(layout);
        idle_.push_back(std::move(tiff));
    }

    codec::Raster read(const codec::PixelWindow& window) const override {
        std::unique_ptr<OpenTiff> tiff = take();
        codec::Raster raster = codec::read_plainly(tiff->handle.get(), layout_, tiff->source, window);
        if (layout_.alpha) codec::split_alpha(raster);
        const std::lock_guard lock(mutex_);
        idle_.push_back(std::move(tiff));  // not after an error: libtiff keeps its first error message
        return raster;
    }

  private:
    std::unique_ptr<OpenTiff> take() const {
        {
            const std::lock_guard lock(mutex_);
            if (!idle_.empty()) {
                std::unique_ptr<OpenTiff> tiff = std::move(idle_.back());
                idle_.pop_back();
                return tiff;
            }
        }
        return std::make_unique<OpenTiff>(*file_);
    }

    std::shared_ptr<const MapFile> file_;
    codec::TiffLayout layout_;
    mutable std::mutex mutex_;
    mutable std::vector<std::unique_ptr<OpenTiff>> idle_;
};

// Reads uncompressed strips as rows of the file, so that only the window's columns are read. Returns null,
// which leaves the file to libtiff, for samples of few bits or doubles, with alpha or in planes, and for
// wrong strip lengths, of which libtiff gives a proper error.
std::unique_ptr<WindowSource> plain_strips(const std::shared_ptr<const MapFile>& file, OpenTiff& tiff,
                                           const codec::TiffLayout& layout) {
    const bool is_float = layout.format == SAMPLEFORMAT_IEEEFP;
    if (TIFFIsTiled(tiff.handle.get()) || layout.compression != COMPRESSION_NONE ||
        layout.photometric == PHOTOMETRIC_MINISWHITE || layout.planes || layout.alpha ||
        layout.samples != layout.channels() ||
        (is_float ? layout.bits != 32 : layout.bits != 8 && layout.bits != 16))
        return nullptr;
    std::uint16_t fill_order = FILLORDER_MSB2LSB;
    std::uint32_t rows_per_strip = 0;
    TIFFGetFieldDefaulted(tiff.handle.get(), TIFFTAG_FILLORDER, &fill_order);
    TIFFGetFieldDefaulted(tiff.handle.get(), TIFFTAG_ROWSPERSTRIP, &rows_per_strip);
    rows_per_strip = std::min(rows_per_strip, layout.height);
    if (fill_order != FILLORDER_MSB2LSB || rows_per_strip == 0) return nullptr;
    std::vector<std::uint64_t> strips;
    for (std::uint32_t top = 0; top < layout.height; top += std::min(rows_per_strip, layout.height - top)) {
        const auto strip = static_cast<std::uint32_t>(strips.size());
        const std::uint64_t at = TIFFGetStrileOffset(tiff.handle.get(), strip);
        const std::uint64_t needed = layout.row_bytes() * std::min(rows_per_strip, layout.height - top);
        if (at > file->bytes() || needed > file->bytes() - at ||
            TIFFGetStrileByteCount(tiff.handle.get(), strip) < needed)
            return nullptr;
        strips.push_back(at);
    }
    const bool swapped = TIFFIsByteSwapped(tiff.handle.get()) != 0;
    return row_windows(file, {.width = static_cast<int>(layout.width),
                              .height = static_cast<int>(layout.height),
                              .sample = sample_of(layout),
                              .channels = layout.channels(),
                              .max_value = layout.bits == 16 ? 65535u : 255u,
                              .is_big_endian = swapped != (std::endian::native == std::endian::big),
                              .row_at =
                                  [strips = std::move(strips), rows_per_strip,
                                   row_bytes = layout.row_bytes()](std::uint32_t y) {
                                      return strips[y / rows_per_strip] + y % rows_per_strip * row_bytes;
                                  },
                              .nodata = codec::nodata_of(tiff.handle.get())});
}

std::unique_ptr<WindowSource> plain_windows(std::shared_ptr<const MapFile> file,
                                            std::unique_ptr<OpenTiff> tiff, const codec::TiffLayout& layout) {
    codec::check_samples(layout, tiff->source);
    if (codec::are_wide_integers(layout))
        codec::refuse(file->path(),
                      "signed integers and those of 32 bits are not read in windows; save it as float32");
    if (auto rows = plain_strips(file, *tiff, layout)) return rows;
    return std::make_unique<TiffWindows>(std::move(file), std::move(tiff), layout);
}

}  // namespace

std::unique_ptr<WindowSource> tiff_windows(std::shared_ptr<const MapFile> file) {
    auto tiff = std::make_unique<OpenTiff>(*file);
    const codec::TiffLayout layout = codec::read_layout(tiff->handle.get(), tiff->source);
    check_map_size(file->path(), layout.width, layout.height);
    if (!codec::stored_plainly(layout) || layout.samples != 1)
        codec::refuse(file->path(),
                      "it has " + std::to_string(layout.samples) +
                          " samples a pixel or a palette, which is not read in windows; save it "
                          "as grey");
    return plain_windows(std::move(file), std::move(tiff), layout);
}

std::unique_ptr<WindowSource> tiff_picture_windows(std::shared_ptr<const MapFile> file) {
    auto tiff = std::make_unique<OpenTiff>(*file);
    const codec::TiffLayout layout = codec::read_layout(tiff->handle.get(), tiff->source);
    if (!codec::stored_plainly(layout)) return nullptr;
    check_map_size(file->path(), layout.width, layout.height);
    return plain_windows(std::move(file), std::move(tiff), layout);
}

}  // namespace hexrelief::readers
