// Reads rows of plain samples: PFM, PGM, PPM, files without a header, and TIFF strips that
// libtiff need not decode.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/netpbm_codec.h"
#include "pipeline/readers/parse_text.h"
#include "pipeline/readers/windows/window_source.h"

namespace hexrelief::readers {
namespace {

constexpr std::size_t kHeaderBytes = 1 << 16;  // most bytes of a PFM's, PGM's or PPM's header, with comments
constexpr int kProbe_px = 256;

std::uint8_t in_other_byte_order(std::uint8_t value) {
    return value;
}
std::uint16_t in_other_byte_order(std::uint16_t value) {
    return static_cast<std::uint16_t>(value >> 8 | value << 8);
}
using codec::in_other_byte_order;

class RowWindows : public WindowSource {
  public:
    RowWindows(std::shared_ptr<const MapFile> file, RowLayout layout)
        : file_(std::move(file)), layout_(std::move(layout)) {
        width = layout_.width;
        height = layout_.height;
        channels = layout_.channels;
        sample = layout_.sample;
    }

    codec::Raster read(const codec::PixelWindow& window) const override {
        codec::Raster raster{.width = static_cast<int>(window.width),
                             .height = static_cast<int>(window.height),
                             .channels = layout_.channels,
                             .max_value = layout_.max_value,
                             .nodata = layout_.nodata};
        if (sample == MapSample::uint8) raster.samples = samples<std::uint8_t>(window);
        if (sample == MapSample::uint16) raster.samples = samples<std::uint16_t>(window);
        if (sample == MapSample::float32) raster.samples = samples<float>(window);
        return raster;
    }

  private:
    template <typename Stored>
    std::vector<Stored> samples(const codec::PixelWindow& window) const {
        const std::size_t pixel_bytes = layout_.channels * sizeof(Stored);
        const std::size_t row_samples = static_cast<std::size_t>(window.width) * layout_.channels;
        std::vector<Stored> values(row_samples * window.height);
        for (std::uint32_t y = 0; y < window.height; ++y) {
            const std::uint64_t at = layout_.row_at(window.y + y) + window.x * pixel_bytes;
            if (!file_->copy(at, values.data() + y * row_samples, row_samples * sizeof(Stored)))
                codec::refuse(file_->path(),
                              "it ends within row " + std::to_string(window.y + y) + "; copy it again");
        }
        if (layout_.is_big_endian != (std::endian::native == std::endian::big))
            for (Stored& value : values) value = in_other_byte_order(value);
        return values;
    }

    std::shared_ptr<const MapFile> file_;
    RowLayout layout_;
};

// True if the middle of the map makes sense only in the other byte order.
bool is_in_other_order(const WindowSource& source) {
    if (source.sample != MapSample::float32) return false;
    const int width = std::min(source.width, kProbe_px), height = std::min(source.height, kProbe_px);
    const auto at = [](int value) { return static_cast<std::uint32_t>(value); };
    const codec::Raster middle = source.read(
        {at((source.width - width) / 2), at((source.height - height) / 2), at(width), at(height)});
    return codec::in_other_order(std::get<std::vector<float>>(middle.samples));
}

[[noreturn]] void refuse_raw(const std::string& text) {
    throw Error(ErrorKind::usage, "'" + codec::printable(text, 60) +
                                      "' is no layout of a raw map; give its size and its samples' type, one "
                                      "of float32, uint16, float32be, uint16be, such as 32768x32768,float32");
}

}  // namespace

MapFile::MapFile(const std::filesystem::path& path) : path_(path) {
    codec::load_head(path, 0);  // refuses folders and pipes
    descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status = {};
    if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0) codec::refuse(path, std::strerror(errno));
    bytes_ = static_cast<std::uint64_t>(status.st_size);
}

MapFile::~MapFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

bool MapFile::copy(std::uint64_t at, void* to, std::size_t count) const {
    for (char* next = static_cast<char*>(to); count > 0;) {
        const ssize_t got = ::pread(descriptor_, next, count, static_cast<off_t>(at));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) codec::refuse(path_, std::strerror(errno));
        if (got == 0) return false;
        next += got;
        at += static_cast<std::uint64_t>(got);
        count -= static_cast<std::size_t>(got);
    }
    return true;
}

std::unique_ptr<WindowSource> row_windows(std::shared_ptr<const MapFile> file, RowLayout layout) {
    return std::make_unique<RowWindows>(std::move(file), std::move(layout));
}

std::unique_ptr<WindowSource> pfm_windows(std::shared_ptr<const MapFile> file) {
    const codec::SourceFile head = codec::load_head(file->path(), kHeaderBytes);
    codec::NetpbmHeader header(head);
    const codec::PfmHeader pfm = codec::read_pfm_header(head, header);
    check_map_size(file->path(), pfm.width, pfm.height);
    if (pfm.channels != 1)
        codec::refuse(file->path(), "it has three channels, a disparity map has one; save it as grey (Pf)");
    const std::uint64_t row_bytes = std::uint64_t{4} * pfm.width, all = row_bytes * pfm.height;
    const std::uint64_t start = header.samples_at(all, file->bytes());
    if (file->bytes() - start - all > 2)  // at most a final line end
        codec::refuse(file->path(), std::to_string(file->bytes() - start - all) +
                                        " bytes follow the last sample, so the header's size is wrong; "
                                        "export it again");
    auto source = row_windows(
        file, {.width = static_cast<int>(pfm.width),
               .height = static_cast<int>(pfm.height),
               .is_big_endian = !pfm.little_endian,
               .row_at = [=](std::uint32_t y) { return start + (pfm.height - 1 - y) * row_bytes; }});
    if (is_in_other_order(*source)) codec::refuse_byte_order(file->path());
    return source;
}

std::unique_ptr<WindowSource> pnm_windows(std::shared_ptr<const MapFile> file) {
    const codec::SourceFile head = codec::load_head(file->path(), kHeaderBytes);
    codec::NetpbmHeader header(head);
    const codec::PnmHeader pnm = codec::read_pnm_header(head, header);
    check_map_size(file->path(), pnm.width, pnm.height);
    const bool is_wide = pnm.max_value > 255;
    const std::uint64_t row_bytes =
        std::uint64_t{pnm.width} * static_cast<unsigned>(pnm.channels) * (is_wide ? 2 : 1);
    const std::uint64_t start = header.samples_at(row_bytes * pnm.height, file->bytes());
    return row_windows(file, {.width = static_cast<int>(pnm.width),
                              .height = static_cast<int>(pnm.height),
                              .sample = is_wide ? MapSample::uint16 : MapSample::uint8,
                              .channels = pnm.channels,
                              .max_value = pnm.max_value,
                              .is_big_endian = true,
                              .row_at = [=](std::uint32_t y) { return start + y * row_bytes; }});
}

RawMapLayout parse_raw_map_layout(const std::string& text) {
    RawMapLayout layout;
    const char *const end = text.data() + text.size(), *at = text.data();
    const auto number = [&](int& value, char after) {
        const auto [next, failure] = std::from_chars(at, end, value);
        if (failure != std::errc() || next == end || *next != after) refuse_raw(text);
        if (value < 1 || value > kLargestMapSide_px)
            throw Error(ErrorKind::usage, "a raw map's sides are 1 to " + std::to_string(kLargestMapSide_px) +
                                              " px, not " + std::to_string(value) + "; check its size");
        at = next + 1;
    };
    number(layout.width, 'x');
    number(layout.height, ',');
    std::string_view type(at, static_cast<std::size_t>(end - at));
    layout.is_big_endian = type.ends_with("be");
    if (layout.is_big_endian) type.remove_suffix(2);
    if (type != "float32" && type != "uint16") refuse_raw(text);
    layout.sample = type == "uint16" ? MapSample::uint16 : MapSample::float32;
    return layout;
}

std::unique_ptr<WindowSource> raw_windows(std::shared_ptr<const MapFile> file, const RawMapLayout& layout) {
    check_map_size(file->path(), static_cast<unsigned>(layout.width), static_cast<unsigned>(layout.height));
    const bool is_wide = layout.sample == MapSample::uint16;
    const std::uint64_t row_bytes = (is_wide ? 2 : 4) * static_cast<std::uint64_t>(layout.width);
    const std::uint64_t all = row_bytes * static_cast<std::uint64_t>(layout.height);
    if (file->bytes() != all)
        codec::refuse(file->path(), "it has " + std::to_string(file->bytes()) + " bytes, " +
                                        size_text(layout.width, layout.height) +
                                        (is_wide ? " uint16" : " float32") + " samples have " +
                                        std::to_string(all) + "; correct the size or the type");
    auto source = row_windows(file, {.width = layout.width,
                                     .height = layout.height,
                                     .sample = layout.sample,
                                     .is_big_endian = layout.is_big_endian,
                                     .row_at = [=](std::uint32_t y) { return y * row_bytes; }});
    if (is_in_other_order(*source))
        codec::refuse(file->path(), std::string("its floats make sense only in the other byte order; give ") +
                                        (layout.is_big_endian ? "float32" : "float32be") + " as their type");
    return source;
}

}  // namespace hexrelief::readers
