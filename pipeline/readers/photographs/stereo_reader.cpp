#include "pipeline/readers/photographs/stereo_reader.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "pipeline/data/crop.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/depth/heic_boxes.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/readers/parse_text.h"
#include "pipeline/readers/photographs/exif.h"
#include "pipeline/readers/photographs/mpo.h"

namespace hexrelief::readers {
namespace {

// Returns the picture at twice its width or height, interpolated linearly between the centres of its pixels.
Image stretched(const Image& image, bool in_x) {
    Image out{
        in_x ? 2 * image.width : image.width, in_x ? image.height : 2 * image.height, image.channels, {}};
    out.pixels.reserve(2 * image.pixels.size());
    for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x) {
            const int near_x = in_x ? x / 2 : x, near_y = in_x ? y : y / 2;
            const int step = (in_x ? x : y) % 2 == 0 ? -1 : 1;
            const std::uint8_t* near = image.at(near_x, near_y);
            const std::uint8_t* far = image.at(std::clamp(near_x + (in_x ? step : 0), 0, image.width - 1),
                                               std::clamp(near_y + (in_x ? 0 : step), 0, image.height - 1));
            for (int channel = 0; channel < image.channels; ++channel)
                out.pixels.push_back(static_cast<std::uint8_t>((3 * near[channel] + far[channel] + 2) / 4));
            if (!image.alpha.empty())
                out.alpha.push_back(image.alpha[static_cast<std::size_t>(near_y) * image.width + near_x]);
        }
    return out;
}

bool is_squeezed(StereoLayout layout) {
    return layout == StereoLayout::half_side_by_side || layout == StereoLayout::half_top_bottom;
}
bool is_side_by_side(StereoLayout layout) {
    return layout == StereoLayout::side_by_side || layout == StereoLayout::half_side_by_side;
}

StereoPair halved(const std::filesystem::path& path, Image image, StereoLayout layout) {
    const bool in_x = is_side_by_side(layout);
    if ((in_x ? image.width : image.height) < 2)
        codec::refuse(path,
                      "its size is " + size_text(image.width, image.height) + ", which has no two halves");
    const int width = in_x ? image.width / 2 : image.width, height = in_x ? image.height : image.height / 2;
    StereoPair pair{cropped(image, {0, 0, width, height}),
                    cropped(image, {image.width - width, image.height - height, width, height})};
    if (is_squeezed(layout)) pair = {stretched(pair.left, in_x), stretched(pair.right, in_x)};
    return pair;
}

// True if the name is that of a side-by-side picture for crossed eyes.
bool is_cross_eyed_name(const std::filesystem::path& path) {
    const std::string extension = codec::lower_case(path.extension().string());
    return extension == ".jps" || extension == ".pns";
}

// How a file that is to be halved holds its views.
struct Halves {
    StereoLayout layout;
    bool is_right_first;
    std::string told;
    bool may_be_squeezed = false;  // the picture's shape decides
};

// Returns the layout and order of the file's own word or name; nullopt if it has none.
std::optional<Halves> own_halves(const codec::SourceFile& source) {
    if (const auto jps = codec::find_jps_layout(source)) {
        const auto [tb, half, left_first] = *jps;
        const StereoLayout layout =
            tb ? (half ? StereoLayout::half_top_bottom : StereoLayout::top_bottom)
               : (half ? StereoLayout::half_side_by_side : StereoLayout::side_by_side);
        return Halves{layout, !left_first,
                      std::string(tb ? "one above the other" : "side by side") + (half ? ", squeezed" : "") +
                          (left_first ? ", left" : ", right") + " view first, by its JPS descriptor"};
    }
    if (!is_cross_eyed_name(source.path)) return std::nullopt;
    return Halves{StereoLayout::side_by_side, true,
                  "side by side, right view first (cross-eyed), as files named " +
                      source.path.extension().string() + " have them"};
}

// Returns the layout that words of a name say, as in holiday-sbs.jpg; nullopt if they say none.
std::optional<Halves> named_halves(const std::filesystem::path& path) {
    static constexpr std::pair<std::string_view, StereoLayout> kWords[] = {
        {"sbs-half", StereoLayout::half_side_by_side},
        {"half-sbs", StereoLayout::half_side_by_side},
        {"hsbs", StereoLayout::half_side_by_side},
        {"sbs", StereoLayout::side_by_side},
        {"side-by-side", StereoLayout::side_by_side},
        {"left-right", StereoLayout::side_by_side},
        {"over-under", StereoLayout::top_bottom},
        {"top-bottom", StereoLayout::top_bottom},
        {"tb", StereoLayout::top_bottom}};
    // As if all words were parted by hyphens, and one stood at both ends.
    std::string name = "-" + codec::lower_case(path.stem().string()) + "-";
    for (char& c : name)
        if (c == '_' || c == ' ' || c == '.') c = '-';
    for (const auto& [words, layout] : kWords)
        if (name.find("-" + std::string(words) + "-") != std::string::npos)
            return Halves{layout, false, "left view first, by '" + std::string(words) + "' in the name",
                          !is_squeezed(layout)};
    return std::nullopt;
}

Halves given_halves(const codec::SourceFile& source, const StereoFileConfig& config) {
    const auto own = own_halves(source);
    const bool is_right_first = config.right_first || (own && own->is_right_first);
    return {config.layout, is_right_first,
            std::string("as input.stereo.layout says, ") + (is_right_first ? "right" : "left") +
                " view first" + (is_right_first && !config.right_first ? ": " + own->told : "")};
}

// True if the picture has about the sides of a screen, 16 to 9: two views of that shape would be twice as
// long.
bool is_screen(const Image& image) {
    return 10 * image.width >= 17 * image.height && 20 * image.width <= 37 * image.height;
}

StereoViews halves_of(codec::SourceFile source, const codec::Codec& codec, Halves halves, int orientation) {
    const std::filesystem::path path = source.path;
    Image image = upright(image_of(codec.decode(std::exchange(source, {})), path), orientation);
    if (halves.may_be_squeezed && is_screen(image)) {
        halves.layout = halves.layout == StereoLayout::top_bottom ? StereoLayout::half_top_bottom
                                                                  : StereoLayout::half_side_by_side;
        halves.told += ", squeezed, as both fill one screen";
    }
    StereoViews read{halved(path, std::move(image), halves.layout), {}, halves.told, halves.is_right_first};
    if (halves.is_right_first) std::swap(read.views.left, read.views.right);
    return read;
}

StereoViews heic_pictures(const codec::SourceFile& source) {
    auto pictures = codec::decode_heic_pair(source);
    if (!pictures)
        codec::refuse(source.path,
                      "it is a HEIC file with one picture; give a spatial photograph, or --left and --right");
    return {
        {image_of(std::move(pictures->left), source.path), image_of(std::move(pictures->right), source.path)},
        pictures->camera,
        "both pictures of its stereo group, left first"};
}

// Returns the part of a file that a picture, a JpegPicture or SecondPicture, takes.
template <typename Picture>
codec::SourceFile part_of(const codec::SourceFile& source, const Picture& picture) {
    const auto first = source.bytes.begin() + static_cast<std::ptrdiff_t>(picture.begin);
    return {
        source.path, {first, first + static_cast<std::ptrdiff_t>(picture.size)}, {}, false, source.limits};
}

std::string told_of(const codec::SecondPicture& second) {
    return second.is_right_first ? "two JPEG pictures, right view first by their numbers"
                                 : "two JPEG pictures, left view first";
}

StereoViews jpeg_pictures(const codec::SourceFile& source, const codec::SecondPicture& second,
                          int orientation) {
    StereoViews read{
        {upright(image_of(codec::decode_jpeg(source), source.path), orientation),
         upright(image_of(codec::decode_jpeg(part_of(source, second)), source.path), orientation)},
        {},
        told_of(second),
        second.is_right_first};
    if (second.is_right_first) std::swap(read.views.left, read.views.right);
    return read;
}

// Returns nullopt also if the file's index is malformed or lists no view, as that of many cameras' previews.
std::optional<codec::SecondPicture> second_view(const codec::SourceFile& source) {
    try {
        return codec::find_second_picture(source);
    } catch (const Error&) {
        return std::nullopt;
    }
}

// Returns the pictures of a file that holds two, or whose halves are told by itself.
StereoViews own_views(codec::SourceFile source, const codec::Codec& codec, StereoLayout layout,
                      int orientation) {
    const auto own = layout == StereoLayout::mpo ? std::nullopt : own_halves(source);
    if (codec.format == codec::Format::heic) return heic_pictures(source);
    if (own) return halves_of(std::move(source), codec, *own, orientation);
    if (const auto second = codec::find_second_picture(source))
        return jpeg_pictures(source, *second, orientation);
    if (const auto named = named_halves(source.path); named && layout != StereoLayout::mpo)
        return halves_of(std::move(source), codec, *named, orientation);
    if (layout == StereoLayout::mpo)
        codec::refuse(source.path,
                      "it holds no second JPEG picture, as MPO files do; give --layout sbs or tb");
    codec::refuse(source.path,
                  "how it holds the two views cannot be told from it; give --layout sbs, sbs-half, tb "
                  "or tb-half");
}

using Lines = std::vector<std::string>;

std::string line(int width, int height, const std::string& role) {
    if (width == 0 || height == 0) return role;
    return size_text(width, height, " x ") + " px, " + role;
}

// Returns a line for the JPEG file in these bytes; its size is left out if its header is malformed.
std::string jpeg_line(const codec::SourceFile& source, const codec::JpegPicture& picture) {
    try {
        const FileDescription found = codec::describe_jpeg(part_of(source, picture));
        return line(found.width, found.height, picture.role);
    } catch (const Error&) {
        return std::string(picture.role) + ", damaged";
    }
}

Lines list_jpeg(const codec::SourceFile& source) {
    const std::vector<codec::JpegPicture> further = codec::list_further_pictures(source);
    if (further.empty()) return {};
    Lines lines = {jpeg_line(source, {0, source.bytes.size(), "the first picture"})};
    for (const codec::JpegPicture& picture : further) lines.push_back(jpeg_line(source, picture));
    return lines;
}

Lines list_heic(const codec::SourceFile& source) {
    Lines lines;
    for (const codec::HeicPicture& picture : codec::list_heic_pictures(source.bytes))
        lines.push_back(line(picture.width, picture.height, picture.role));
    return lines.size() > 1 ? lines : Lines{};
}

}  // namespace

bool names_layout(const std::filesystem::path& path) {
    return named_halves(path).has_value();
}

StereoViews read_stereo_file(const std::filesystem::path& path, const StereoFileConfig& config,
                             const ReaderLimits& limits, bool is_upright) {
    const codec::Codec& codec = require_image_codec(path);
    const int orientation = is_upright ? read_orientation(path) : kUpright;
    codec::SourceFile source = codec::load_raster_file(path, limits);
    if (config.layout != StereoLayout::automatic && config.layout != StereoLayout::mpo) {
        const Halves halves = given_halves(source, config);
        return halves_of(std::move(source), codec, halves, orientation);
    }
    StereoViews read = own_views(std::move(source), codec, config.layout, orientation);
    if (config.right_first && !read.is_right_first) {
        std::swap(read.views.left, read.views.right);
        read.camera.doffs_px = -read.camera.doffs_px;
        read.told += ", exchanged by input.stereo.right_first";
    }
    const Image &left = read.views.left, &right = read.views.right;
    if (left.width != right.width || left.height != right.height)
        codec::refuse(path, "its pictures have " + size_text(left.width, left.height) + " and " +
                                size_text(right.width, right.height) +
                                " px; the views of a pair have one size");
    if (orientation != kUpright) read.told += "; " + orientation_text(orientation) + " by EXIF";
    return read;
}

std::optional<StereoFileDescription> describe_stereo_file(const std::filesystem::path& path,
                                                          const ReaderLimits& limits) {
    const codec::Codec* const codec = codec::find_codec(path);
    if (!codec || (codec->gives & codec::kPicture) == 0) return std::nullopt;
    const codec::SourceFile source = codec::load_raster_file(path, limits);
    if (codec->format == codec::Format::heic) {
        const auto pair = codec::find_heic_pair(source.bytes);
        if (!pair) return std::nullopt;
        return StereoFileDescription{pair->width, pair->height, pair->camera,
                                     "both pictures of its stereo group, left first"};
    }
    if (const auto own = own_halves(source)) {
        const FileDescription whole = codec->describe(source);
        const bool in_x = is_side_by_side(own->layout);
        return StereoFileDescription{
            in_x ? whole.width / 2 : whole.width, in_x ? whole.height : whole.height / 2, {}, own->told};
    }
    const auto second = (codec->gives & codec::kBothViews) != 0 ? second_view(source) : std::nullopt;
    if (!second) return std::nullopt;
    const FileDescription first = codec->describe(source), other = codec->describe(part_of(source, *second));
    if (first.width != other.width || first.height != other.height) return std::nullopt;
    return StereoFileDescription{other.width, other.height, {}, told_of(*second)};
}

std::vector<std::string> list_pictures(const std::filesystem::path& path, const ReaderLimits& limits) {
    const codec::Codec* const codec = codec::find_codec(path);
    const codec::Format format = codec ? codec->format : codec::Format::png;
    if (format == codec::Format::jpeg) return list_jpeg(codec::load_raster_file(path, limits));
    if (format == codec::Format::heic) return list_heic(codec::load_raster_file(path, limits));
    return {};
}

}  // namespace hexrelief::readers
