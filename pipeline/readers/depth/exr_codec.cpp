// Reads OpenEXR by its C library: one channel of the first part.
#include "pipeline/readers/codecs.h"

#ifdef HEXRELIEF_HAS_OPENEXR
#include <openexr.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <memory>

#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

// The largest half float; renderers write it for pixels where no surface is hit.
constexpr float kLargestHalf = 65504;

int64_t on_read(exr_const_context_t, void* user, void* to, uint64_t count, uint64_t offset,
                exr_stream_error_func_ptr_t) {
    const auto& source = *static_cast<const SourceFile*>(user);
    if (offset > source.size()) return -1;
    return static_cast<int64_t>(source.read_at(offset, to, count));
}

int64_t on_size(exr_const_context_t, void* user) {
    return static_cast<int64_t>(static_cast<const SourceFile*>(user)->size());
}

void on_error(exr_const_context_t, exr_result_t, const char*) {}

struct Closer {
    void operator()(exr_context_t context) const { exr_finish(&context); }
};
using Context = std::unique_ptr<std::remove_pointer_t<exr_context_t>, Closer>;

void check(const SourceFile& source, exr_result_t result) {
    if (result != EXR_ERR_SUCCESS)
        refuse(source.path, std::string("malformed or truncated EXR: ") +
                                exr_get_default_error_message(result) + "; copy or save it again");
}

Context open(const SourceFile& source) {
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.user_data = const_cast<SourceFile*>(&source);
    setup.read_fn = on_read;
    setup.size_fn = on_size;
    setup.error_handler_fn = on_error;
    exr_context_t context = nullptr;
    check(source, exr_start_read(&context, "file", &setup));
    return Context(context);
}

struct Layout {
    exr_storage_t storage = EXR_STORAGE_LAST_TYPE;
    int left = 0, top = 0, width = 0, height = 0;
    int channels = 0;
    std::string name;  // name of the channel
    exr_pixel_type_t type = EXR_PIXEL_FLOAT;
};

std::string lower_case(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

// Returns the channel that the key names, the only one, or the first with one of the usual names for maps,
// with or without a layer's name in front.
const exr_attr_chlist_entry_t& chosen_channel(const SourceFile& source, const exr_attr_chlist_t& list) {
    const auto* const first = list.entries;
    const auto* const last = first + list.num_channels;
    const auto find = [&](auto is_wanted) {
        return std::find_if(first, last, [&](const auto& entry) { return is_wanted(entry.name.str); });
    };
    std::string names;
    for (const auto* entry = first; entry != last; ++entry)
        names += (names.empty() ? "" : ", ") + std::string(entry->name.str);
    names = printable(names, 400);
    if (!source.key.empty()) {
        const auto* const found = find([&](const char* name) { return source.key == name; });
        if (found == last)
            refuse(source.path, "it has no channel " + excerpt(source.key) + "; it has " + names);
        return *found;
    }
    if (list.num_channels == 1) return *first;
    for (const char* const usual : {"z", "depth", "disparity", "y", "r"}) {
        const auto* const found = find([&](const std::string& name) {
            return lower_case(name.substr(name.rfind('.') + 1)) == usual || lower_case(name) == usual;
        });
        if (found != last) return *found;
    }
    refuse(source.path, "it has several channels; " + std::string(source.several) + ": " + names);
}

Layout read_layout(const SourceFile& source, exr_const_context_t context) {
    Layout layout;
    exr_attr_box2i_t window{};
    const exr_attr_chlist_t* channels = nullptr;
    check(source, exr_get_storage(context, 0, &layout.storage));
    check(source, exr_get_data_window(context, 0, &window));
    check(source, exr_get_channels(context, 0, &channels));
    if (layout.storage != EXR_STORAGE_SCANLINE && layout.storage != EXR_STORAGE_TILED)
        refuse(source.path, "it holds deep samples; save it with one depth for each pixel");
    const long long width = 1LL + window.max.x - window.min.x, height = 1LL + window.max.y - window.min.y;
    check_size(source, static_cast<unsigned long long>(std::max(width, 0LL)),
               static_cast<unsigned long long>(std::max(height, 0LL)));
    if (channels->num_channels < 1) refuse(source.path, "it has no channels");
    const exr_attr_chlist_entry_t& channel = chosen_channel(source, *channels);
    if (channel.x_sampling != 1 || channel.y_sampling != 1)
        refuse(source.path, "its channel is subsampled; save it with a sample for each pixel");
    layout.left = window.min.x;
    layout.top = window.min.y;
    layout.width = static_cast<int>(width);
    layout.height = static_cast<int>(height);
    layout.channels = channels->num_channels;
    layout.name = channel.name.str;
    layout.type = channel.pixel_type;
    return layout;
}

// Decodes the layout's channel chunk by chunk.
class ChunkReader {
  public:
    ChunkReader(const SourceFile& source, exr_const_context_t context, const Layout& layout)
        : source_(source), context_(context), layout_(layout) {}
    ChunkReader(const ChunkReader&) = delete;
    ChunkReader& operator=(const ChunkReader&) = delete;
    ~ChunkReader() {
        if (is_started_) exr_decoding_destroy(context_, &pipeline_);
    }

    // Returns the chunk's pixels, row by row.
    const std::vector<float>& read(const exr_chunk_info_t& chunk) {
        check(source_, is_started_ ? exr_decoding_update(context_, 0, &chunk, &pipeline_)
                                   : exr_decoding_initialize(context_, 0, &chunk, &pipeline_));
        is_started_ = true;
        const std::size_t area = static_cast<std::size_t>(chunk.width) * chunk.height;
        if (area * pipeline_.channel_count > (std::size_t{1} << 30))
            refuse(source_.path, "its chunks and channels are too many; save the map's channel alone");
        // All channels are decoded: the library's fastest routines crash if one is left out.
        others_.resize(area * pipeline_.channel_count);
        pixels_.resize(area);
        for (int i = 0; i < pipeline_.channel_count; ++i) {
            exr_coding_channel_info_t& channel = pipeline_.channels[i];
            float* const to =
                layout_.name == channel.channel_name ? pixels_.data() : others_.data() + i * area;
            channel.decode_to_ptr = reinterpret_cast<std::uint8_t*>(to);
            channel.user_pixel_stride = sizeof(float);
            channel.user_line_stride = static_cast<int>(sizeof(float)) * chunk.width;
            channel.user_bytes_per_element = sizeof(float);
            channel.user_data_type = EXR_PIXEL_FLOAT;
        }
        check(source_, exr_decoding_choose_default_routines(context_, 0, &pipeline_));
        check(source_, exr_decoding_run(context_, 0, &pipeline_));
        return pixels_;
    }

  private:
    const SourceFile& source_;
    exr_const_context_t context_;
    const Layout& layout_;
    exr_decode_pipeline_t pipeline_ = EXR_DECODE_PIPELINE_INITIALIZER;
    bool is_started_ = false;
    std::vector<float> pixels_, others_;
};

void put(const std::vector<float>& pixels, const exr_chunk_info_t& chunk, int x, int y, const Layout& layout,
         std::vector<float>& samples) {
    for (int row = 0; row < chunk.height && y + row < layout.height; ++row)
        std::copy_n(pixels.begin() + static_cast<std::ptrdiff_t>(row) * chunk.width,
                    std::min(chunk.width, layout.width - x),
                    samples.begin() + static_cast<std::ptrdiff_t>(y + row) * layout.width + x);
}

void check_chunk(const SourceFile& source, const exr_chunk_info_t& chunk, const Layout& layout) {
    if (chunk.width < 1 || chunk.height < 1 || chunk.width > layout.width || chunk.height > layout.height)
        refuse(source.path, "malformed EXR: impossible chunk; save it again");
}

std::vector<float> read_scanlines(const SourceFile& source, exr_const_context_t context, const Layout& layout,
                                  std::vector<float> samples) {
    std::int32_t rows = 0;
    check(source, exr_get_scanlines_per_chunk(context, 0, &rows));
    if (rows < 1) refuse(source.path, "malformed EXR: no rows in a chunk");
    ChunkReader reader(source, context, layout);
    for (int y = 0; y < layout.height; y += rows) {
        exr_chunk_info_t chunk;
        check(source, exr_read_scanline_chunk_info(context, 0, layout.top + y, &chunk));
        check_chunk(source, chunk, layout);
        put(reader.read(chunk), chunk, 0, y, layout, samples);
    }
    return samples;
}

std::vector<float> read_tiles(const SourceFile& source, exr_const_context_t context, const Layout& layout,
                              std::vector<float> samples) {
    std::int32_t width = 0, height = 0;
    check(source, exr_get_tile_sizes(context, 0, 0, 0, &width, &height));
    if (width < 1 || height < 1) refuse(source.path, "malformed EXR: empty tiles");
    ChunkReader reader(source, context, layout);
    for (int y = 0; y < layout.height; y += height)
        for (int x = 0; x < layout.width; x += width) {
            exr_chunk_info_t chunk;
            check(source, exr_read_tile_chunk_info(context, 0, x / width, y / height, 0, 0, &chunk));
            check_chunk(source, chunk, layout);
            put(reader.read(chunk), chunk, x, y, layout, samples);
        }
    return samples;
}

}  // namespace

FileDescription describe_exr(const SourceFile& source) {
    const Context context = open(source);
    const Layout layout = read_layout(source, context.get());
    const bool is_half = layout.type == EXR_PIXEL_HALF;
    return {"exr",           layout.width,      layout.height,
            layout.channels, is_half ? 16 : 32, layout.type != EXR_PIXEL_UINT};
}

Raster decode_exr(const SourceFile& source) {
    const Context context = open(source);
    const Layout layout = read_layout(source, context.get());
    // A map with a single value compresses well, but not without limit.
    constexpr unsigned best_ratio = 65536;
    const std::size_t pixels = static_cast<std::size_t>(layout.width) * layout.height;
    check_length(source, pixels * sizeof(float), best_ratio);
    std::vector<float> samples(pixels);
    samples = layout.storage == EXR_STORAGE_TILED
                  ? read_tiles(source, context.get(), layout, std::move(samples))
                  : read_scanlines(source, context.get(), layout, std::move(samples));
    Raster raster;
    raster.width = layout.width;
    raster.height = layout.height;
    raster.max_value = 0;
    if (layout.type == EXR_PIXEL_HALF) raster.nodata = kLargestHalf;
    raster.samples = std::move(samples);
    return raster;
}

}  // namespace hexrelief::readers::codec

#else

namespace hexrelief::readers::codec {
namespace {

[[noreturn]] void refuse_unbuilt(const SourceFile& source) {
    refuse(
        source.path,
        "it is an OpenEXR file, and this hexrelief was built without OpenEXR; build it with libopenexr-dev "
        "installed, or save the map as NPY, PFM or TIFF");
}

}  // namespace

FileDescription describe_exr(const SourceFile& source) {
    refuse_unbuilt(source);
}

Raster decode_exr(const SourceFile& source) {
    refuse_unbuilt(source);
}

}  // namespace hexrelief::readers::codec

#endif
