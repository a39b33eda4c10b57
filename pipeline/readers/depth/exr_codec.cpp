// Reads OpenEXR: one channel of one part, or three of colours, in the display window.
#include "pipeline/data/number_text.h"
#include "pipeline/readers/codecs.h"

#ifdef HEXRELIEF_HAS_OPENEXR
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>
#include <ImfTileDescription.h>

#include <algorithm>
#include <array>
#include <optional>

#include "pipeline/readers/depth/map_names.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

using Imath::Box2i;

// The largest half float; renderers write it for pixels where no surface is hit.
constexpr float kLargestHalf = 65504;
constexpr int kBandRows = 64;
constexpr std::size_t kMostBandSamples = 1 << 24;

class Stream : public Imf::IStream {
  public:
    explicit Stream(const SourceFile& source) : IStream("the file"), source_(source) {}
    bool read(char to[], int count) override {
        const auto wanted = static_cast<std::size_t>(std::max(count, 0));
        if (source_.read_at(at_, to, wanted) != wanted) throw Iex::InputExc("it ends too early");
        at_ += wanted;
        return at_ < source_.size();
    }
    std::uint64_t tellg() override { return at_; }
    void seekg(std::uint64_t at) override { at_ = at; }

  private:
    const SourceFile& source_;
    std::uint64_t at_ = 0;
};

// Refuses a header with an attribute longer than the file: the library takes memory for it before it reads.
// An attribute is a name and a type, each ended by a zero, four bytes of length and the value; an empty name
// ends the header of a part, and another one those of several parts.
void check_attributes(const SourceFile& source) {
    std::array<std::uint8_t, 520> head{};  // holds the longest names
    source.read_at(0, head.data(), 8);
    const bool has_parts = (head[5] & 0x10) != 0;
    bool ended = false;
    for (std::uint64_t at = 8;;) {
        const auto end =
            head.begin() + static_cast<std::ptrdiff_t>(source.read_at(at, head.data(), head.size()));
        const auto name_end = std::find(head.begin(), end, 0);
        if (name_end == end || (name_end == head.begin() && (!has_parts || ended))) return;
        ended = name_end == head.begin();
        if (ended) {
            ++at;
            continue;
        }
        const auto type_end = std::find(name_end + 1, end, 0);
        if (end - type_end < 5) return;
        std::uint32_t length = 0;
        for (int i = 4; i > 0; --i) length = length << 8 | type_end[i];
        at += static_cast<std::uint64_t>(type_end + 5 - head.begin()) + length;
        if (at > source.size()) throw Iex::InputExc("an attribute is longer than the file");
    }
}

template <typename Read>
auto guarded(const SourceFile& source, Read read) {
    try {
        check_attributes(source);
        return read();
    } catch (const Iex::BaseExc& error) {
        refuse(source.path,
               "malformed or truncated EXR: " + printable(error.what(), 200) + "; copy or save it again");
    }
}

// One channel of a part with a sample for each pixel.
struct Channel {
    int part = 0;
    std::string name;       // in the file
    std::string full_name;  // with the part's name, if there are several parts
    Imf::PixelType type = Imf::FLOAT;
    bool is_subsampled = false;
};

std::string part_name(const Imf::Header& header, int part) {
    return header.hasName() ? header.name() : std::to_string(part);
}

std::vector<Channel> channels_of(const SourceFile& source, const Imf::MultiPartInputFile& file) {
    std::vector<Channel> channels;
    for (int part = 0; part < file.parts(); ++part) {
        const Imf::Header& header = file.header(part);
        if (header.hasType() && Imf::isDeepData(header.type())) continue;
        const std::string before = file.parts() > 1 ? part_name(header, part) + "." : "";
        for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) {
            const Imf::Channel& kind = channel.channel();
            channels.push_back({part, channel.name(), before + channel.name(), kind.type,
                                kind.xSampling != 1 || kind.ySampling != 1});
        }
    }
    if (channels.empty())
        refuse(source.path, "it has no channels but deep ones; save it with one depth for each pixel");
    return channels;
}

std::vector<Channel> colors_of(const std::vector<Channel>& channels) {
    for (const Channel& first : channels) {
        std::vector<Channel> colors;
        for (const char* const name : {"R", "G", "B"})
            for (const Channel& channel : channels)
                if (channel.part == first.part && channel.name == name) colors.push_back(channel);
        if (colors.size() == 3) return colors;
    }
    return {};
}

// Returns the channel of the only part that has one alone; nothing if there are several such parts, or none.
std::optional<Channel> alone_in_its_part(const std::vector<Channel>& channels) {
    std::optional<Channel> found;
    for (const Channel& channel : channels) {
        if (std::ranges::count(channels, channel.part, &Channel::part) != 1) continue;
        if (found) return std::nullopt;
        found = channel;
    }
    return found;
}

// Returns the channel that the key names, the only one, the one with the most usual name, or that of a part
// of its own; three if there are only colours, and for a picture if there are any.
std::vector<Channel> chosen_channels(const SourceFile& source, const std::vector<Channel>& channels) {
    std::vector<std::string> names(channels.size());
    std::ranges::transform(channels, names.begin(), &Channel::full_name);
    const std::string text = printable(joined(names, ", "), 400);
    if (!source.key.empty()) {
        auto found = std::ranges::find(channels, source.key, &Channel::full_name);
        if (found == channels.end()) found = std::ranges::find(channels, source.key, &Channel::name);
        if (found == channels.end())
            refuse(source.path, "it has no channel " + excerpt(source.key) + "; it has " + text);
        return {*found};
    }
    if (channels.size() == 1) return channels;
    const bool is_picture = !source.is_map && source.wanted == Wanted::map;
    std::vector<Channel> colors = colors_of(channels);
    if (is_picture && !colors.empty()) return colors;
    if (const auto usual = usual_name(names, source.wanted)) return {channels[*usual]};
    if (const auto alone = alone_in_its_part(channels)) return {*alone};
    if (!colors.empty()) return colors;
    for (const char* const name : {"Y", "R"})
        if (const auto found = std::ranges::find(channels, name, &Channel::name); found != channels.end())
            return {*found};
    refuse(source.path, "it has several channels; " + std::string(source.several) + ": " + text);
}

struct Layout {
    std::vector<Channel> channels;
    Box2i data, display;
    int band_rows = kBandRows;  // rows that are decoded at once
    std::size_t all_channels = 0;

    static long long width(const Box2i& box) { return 1LL + box.max.x - box.min.x; }
    static long long height(const Box2i& box) { return 1LL + box.max.y - box.min.y; }
};

void check_box(const SourceFile& source, const Box2i& box) {
    check_size(source, static_cast<unsigned long long>(std::max(Layout::width(box), 0LL)),
               static_cast<unsigned long long>(std::max(Layout::height(box), 0LL)));
}

Layout layout_of(const SourceFile& source, const Imf::MultiPartInputFile& file) {
    Layout layout;
    layout.channels = chosen_channels(source, channels_of(source, file));
    const Imf::Header& header = file.header(layout.channels.front().part);
    layout.data = header.dataWindow();
    layout.display = header.displayWindow();
    check_box(source, layout.data);
    check_box(source, layout.display);
    if (!layout.data.intersects(layout.display))
        refuse(source.path, "its data window lies outside of its display window; crop or save it again");
    // What lies outside of the data window takes no bytes in the file, but memory.
    constexpr long long small = 1 << 24, most_times = 64;
    const auto area = [](const Box2i& box) { return Layout::width(box) * Layout::height(box); };
    if (area(layout.display) > std::max(small, most_times * area(layout.data)))
        refuse(source.path,
               "its display window has more than 64 times the pixels of its data window; crop it");
    for (const Channel& channel : layout.channels)
        if (channel.is_subsampled)
            refuse(source.path, "its channel is subsampled; save it with a sample for each pixel");
    for (auto one = header.channels().begin(); one != header.channels().end(); ++one) ++layout.all_channels;
    std::uint64_t chunk = static_cast<std::uint64_t>(Layout::width(layout.data)) * 256;  // the highest is 256
    if (header.hasTileDescription()) {
        const Imf::TileDescription& tiles = header.tileDescription();
        chunk = std::uint64_t{tiles.xSize} * tiles.ySize;
        layout.band_rows = static_cast<int>(std::min<std::uint64_t>(tiles.ySize, 4096));
    }
    if (chunk * layout.all_channels > (std::uint64_t{1} << 28))
        refuse(source.path, "its chunks and channels are too many; save the map's channel alone");
    return layout;
}

class BandReader {
  public:
    BandReader(Imf::MultiPartInputFile& file, const Layout& layout)
        : part_(file, layout.channels.front().part), layout_(layout) {
        const auto row = static_cast<std::size_t>(Layout::width(layout.data)) * layout.channels.size();
        rows_ = static_cast<int>(
            std::clamp<std::size_t>(kMostBandSamples / row, 1, static_cast<std::size_t>(layout.band_rows)));
    }

    // Returns the row's samples, channels interleaved.
    const float* row(int y) {
        const auto stride = static_cast<std::size_t>(Layout::width(layout_.data)) * layout_.channels.size();
        if (band_.empty() || y < top_ || y >= top_ + rows_) read(y, stride);
        return band_.data() + static_cast<std::size_t>(y - top_) * stride;
    }

  private:
    void read(int y, std::size_t stride) {
        const int first = layout_.data.min.y;
        top_ = first + (y - first) / rows_ * rows_;
        const int last = std::min(top_ + rows_ - 1, layout_.data.max.y);
        band_.resize(stride * static_cast<std::size_t>(rows_));
        Imf::FrameBuffer frame;
        for (std::size_t i = 0; i < layout_.channels.size(); ++i)
            frame.insert(layout_.channels[i].name,
                         Imf::Slice::Make(Imf::FLOAT, band_.data() + i, Imath::V2i(layout_.data.min.x, top_),
                                          Layout::width(layout_.data), last - top_ + 1,
                                          sizeof(float) * layout_.channels.size(), sizeof(float) * stride));
        part_.setFrameBuffer(frame);
        part_.readPixels(top_, last);
    }

    Imf::InputPart part_;
    const Layout& layout_;
    int rows_ = 1, top_ = 0;
    std::vector<float> band_;
};

// Returns the samples of the display window; those outside of the data window are NaN.
std::vector<float> read_display(Imf::MultiPartInputFile& file, const Layout& layout) {
    const std::size_t channels = layout.channels.size();
    const Box2i &data = layout.data, &display = layout.display;
    const int left = std::max(data.min.x, display.min.x), right = std::min(data.max.x, display.max.x);
    const auto at = [&](int x, const Box2i& box) {
        return static_cast<std::size_t>(x - box.min.x) * channels;
    };
    std::vector<float> samples;
    samples.reserve(static_cast<std::size_t>(Layout::width(display) * Layout::height(display)) * channels);
    BandReader reader(file, layout);
    const auto fill = [&](std::size_t count) {
        samples.insert(samples.end(), count, static_cast<float>(kNoData));
    };
    for (int y = display.min.y; y <= display.max.y; ++y) {
        if (y < data.min.y || y > data.max.y) {
            fill(at(display.max.x + 1, display));
            continue;
        }
        const float* const row = reader.row(y);
        fill(at(left, display));
        samples.insert(samples.end(), row + at(left, data), row + at(right + 1, data));
        fill(at(display.max.x, display) - at(right, display));
    }
    return samples;
}

std::string box_text(const Box2i& box) {
    return std::to_string(Layout::width(box)) + " x " + std::to_string(Layout::height(box)) + " px at " +
           std::to_string(box.min.x) + "," + std::to_string(box.min.y);
}

const char* type_text(Imf::PixelType type) {
    return type == Imf::HALF ? "half" : type == Imf::FLOAT ? "float" : "uint";
}

}  // namespace

FileDescription describe_exr(const SourceFile& source) {
    return guarded(source, [&]() -> FileDescription {
        Stream stream(source);
        const Imf::MultiPartInputFile file(stream, 0, false);
        const Layout layout = layout_of(source, file);
        const Imf::PixelType type = layout.channels.front().type;
        return {"exr",
                static_cast<int>(Layout::width(layout.display)),
                static_cast<int>(Layout::height(layout.display)),
                static_cast<int>(layout.all_channels),
                type == Imf::HALF ? 16 : 32,
                type != Imf::UINT};
    });
}

std::vector<std::string> list_exr(const SourceFile& source) {
    return guarded(source, [&] {
        Stream stream(source);
        const Imf::MultiPartInputFile file(stream, 0, false);
        std::vector<std::string> lines;
        for (int part = 0; part < file.parts(); ++part) {
            const Imf::Header& header = file.header(part);
            std::string line = file.parts() > 1 ? "part " + part_name(header, part) + ": " : "";
            const char* separator = "";
            for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) {
                line += std::string(separator) + channel.name() + " " + type_text(channel.channel().type);
                separator = ", ";
            }
            if (header.dataWindow() != header.displayWindow())
                line += "; data window " + box_text(header.dataWindow()) + ", display window " +
                        box_text(header.displayWindow());
            lines.push_back(line);
        }
        return lines;
    });
}

Raster decode_exr(const SourceFile& source) {
    return guarded(source, [&] {
        Stream stream(source);
        Imf::MultiPartInputFile file(stream, 0, false);
        const Layout layout = layout_of(source, file);
        // A map with a single value compresses well, but not without limit.
        constexpr unsigned best_ratio = 65536;
        for (const Box2i& box : {layout.data, layout.display})
            check_length(
                source,
                static_cast<unsigned long long>(Layout::width(box) * Layout::height(box)) * sizeof(float),
                best_ratio);
        Raster raster{.width = static_cast<int>(Layout::width(layout.display)),
                      .height = static_cast<int>(Layout::height(layout.display)),
                      .channels = static_cast<int>(layout.channels.size()),
                      .max_value = 0};
        if (layout.channels.front().type == Imf::HALF) raster.nodata = kLargestHalf;
        raster.samples = read_display(file, layout);
        return raster;
    });
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

std::vector<std::string> list_exr(const SourceFile& source) {
    refuse_unbuilt(source);
}

Raster decode_exr(const SourceFile& source) {
    refuse_unbuilt(source);
}

}  // namespace hexrelief::readers::codec

#endif
