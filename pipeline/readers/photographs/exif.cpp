#include "pipeline/readers/photographs/exif.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "pipeline/readers/codecs.h"
#include "pipeline/readers/depth/heic_boxes.h"

namespace hexrelief::readers {
namespace {

using codec::SourceFile;
using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kMostBytes = 1 << 20;

// Returns a number of the file; 0 if it lies beyond its end.
std::uint32_t number_at(const SourceFile& file, std::uint64_t at, int count, bool little_endian) {
    std::uint8_t bytes[4] = {};
    if (file.read_at(at, bytes, static_cast<std::size_t>(count)) != static_cast<std::size_t>(count)) return 0;
    std::uint32_t value = 0;
    for (int i = 0; i < count; ++i)
        value |= static_cast<std::uint32_t>(bytes[i]) << 8 * (little_endian ? i : count - 1 - i);
    return value;
}

Bytes part_of(const SourceFile& file, std::uint64_t at, std::uint64_t count) {
    Bytes part(static_cast<std::size_t>(std::min<std::uint64_t>(count, kMostBytes)));
    part.resize(file.read_at(at, part.data(), part.size()));
    return part;
}

constexpr std::string_view kPrefix("Exif\0\0", 6);

Bytes without_prefix(Bytes bytes) {
    if (bytes.size() >= kPrefix.size() && std::equal(kPrefix.begin(), kPrefix.end(), bytes.begin()))
        bytes.erase(bytes.begin(), bytes.begin() + kPrefix.size());
    return bytes;
}

Bytes exif_of_jpeg(const SourceFile& file) {
    constexpr std::uint32_t exif = 0xffe1, scan = 0xffda;
    std::uint64_t at = 2;
    for (std::uint32_t marker; (marker = number_at(file, at, 2, false)) > 0xffbf && marker != scan;) {
        const std::uint32_t length = number_at(file, at + 2, 2, false);
        if (length < 2) break;
        if (marker == exif && number_at(file, at + 4, 4, false) == 0x45786966)
            return without_prefix(part_of(file, at + 4, length - 2));
        at += 2 + length;
    }
    return {};
}

// Returns the content of the first chunk of this name. Sizes and names come in another order in each format.
Bytes chunk_of(const SourceFile& file, std::uint64_t at, std::uint32_t name, bool is_png) {
    while (at + 8 <= file.size()) {
        const std::uint32_t size = number_at(file, at + (is_png ? 0 : 4), 4, !is_png);
        if (number_at(file, at + (is_png ? 4 : 0), 4, false) == name)
            return without_prefix(part_of(file, at + 8, size));
        at += is_png ? 12ull + size : 8ull + size + size % 2;
    }
    return {};
}

int orientation_in(const SourceFile& tiff) {
    constexpr std::uint32_t orientation_tag = 0x112, big_tiff = 43;
    const bool little = number_at(tiff, 0, 2, false) == 0x4949;
    if (number_at(tiff, 2, 2, little) == big_tiff) return kUpright;
    const std::uint64_t directory = number_at(tiff, 4, 4, little);
    const std::uint32_t entries = number_at(tiff, directory, 2, little);
    for (std::uint32_t i = 0; i < entries; ++i) {
        const std::uint64_t entry = directory + 2 + 12ull * i;
        if (number_at(tiff, entry, 2, little) != orientation_tag) continue;
        const std::uint32_t value = number_at(tiff, entry + 8, 2, little);
        return value >= 1 && value <= 8 ? static_cast<int>(value) : kUpright;
    }
    return kUpright;
}

// Returns how far the aspects of a picture and of a map are from each other, as a logarithm.
double aspect_difference(const Image& image, int width, int height) {
    return std::fabs(std::log(1.0 * image.width * height / (1.0 * image.height * width)));
}

std::string turn(OrientedPicture& picture) {
    picture.image = upright(std::move(picture.image), picture.orientation);
    return picture.path.string() + " is " + orientation_text(picture.orientation) +
           ", as its EXIF orientation says";
}

}  // namespace

std::vector<std::uint8_t> read_exif(const std::filesystem::path& path) {
    const codec::Codec* const codec = codec::find_codec(path);
    if (!codec) return {};
    switch (codec->format) {
        case codec::Format::jpeg:
            return exif_of_jpeg(codec::open_file(path, 1 << 12));
        case codec::Format::png:
            return chunk_of(codec::open_file(path, 1 << 12), 8, 0x65584966, true);  // eXIf
        case codec::Format::webp:
            return chunk_of(codec::open_file(path, 1 << 12), 12, 0x45584946, false);  // EXIF
        case codec::Format::heic:
            return codec::heic_exif(codec::load_raster_file(path).bytes);
        default:
            return {};
    }
}

int read_orientation(const std::filesystem::path& path) {
    const codec::Codec* const codec = codec::find_codec(path);
    if (!codec || codec->format == codec::Format::heic) return kUpright;
    if (codec->format == codec::Format::tiff) return orientation_in(codec::open_file(path, 1 << 12));
    const Bytes exif = read_exif(path);
    return exif.empty() ? kUpright : orientation_in({path, exif});
}

Image upright(Image image, int orientation) {
    if (orientation == kUpright) return image;
    const bool transposed = is_quarter_turn(orientation);
    const bool flips_x = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
    const bool flips_y = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
    Image out{transposed ? image.height : image.width, transposed ? image.width : image.height,
              image.channels, Bytes(image.pixels.size()), Bytes(image.alpha.size())};
    for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x) {
            const int column = transposed ? y : x, row = transposed ? x : y;
            const int from_x = flips_x ? image.width - 1 - column : column;
            const int from_y = flips_y ? image.height - 1 - row : row;
            std::copy_n(image.at(from_x, from_y), image.channels, out.at(x, y));
            if (!out.alpha.empty())
                out.alpha[static_cast<std::size_t>(y) * out.width + x] =
                    image.alpha[static_cast<std::size_t>(from_y) * image.width + from_x];
        }
    return out;
}

std::string orientation_text(int orientation) {
    static constexpr const char* texts[] = {"taken as stored",
                                            "mirrored",
                                            "turned by half",
                                            "turned upside down",
                                            "turned by a quarter and mirrored",
                                            "turned by a quarter clockwise",
                                            "turned by a quarter and mirrored",
                                            "turned by a quarter counter-clockwise"};
    return texts[orientation - 1];
}

Turning turn_upright(OrientedPicture& left, OrientedPicture& right, bool has_calibration) {
    Turning done;
    const bool is_stored_equal =
        left.image.width == right.image.width && left.image.height == right.image.height;
    if (is_stored_equal && is_quarter_turn(left.orientation) != is_quarter_turn(right.orientation)) {
        done.warnings.push_back("the EXIF orientations of " + left.path.string() + " and " +
                                right.path.string() +
                                " would give them different sizes: both are taken as stored");
        return done;
    }
    for (OrientedPicture* const picture : {&left, &right}) {
        if (picture->orientation == kUpright) continue;
        const std::string told = turn(*picture);
        if (has_calibration)
            done.warnings.push_back(
                told +
                "; if the calibration is for the picture as stored, set input.exif_orientation to "
                "false");
        else
            done.decisions.push_back("orientation: " + told);
    }
    return done;
}

Turning turn_to_fit(OrientedPicture& color, int width, int height) {
    Turning done;
    if (color.orientation == kUpright) return done;
    const bool is_quarter = is_quarter_turn(color.orientation);
    const double stored = aspect_difference(color.image, width, height);
    const double turned = is_quarter ? aspect_difference(color.image, height, width) : stored;
    if (turned < stored)
        done.decisions.push_back("orientation: " + turn(color) + ", to fit the map");
    else if (turned > stored)
        done.decisions.push_back("orientation: " + color.path.string() +
                                 " is taken as stored, as the map is");
    else
        done.warnings.push_back(
            "the map fits " + color.path.string() + " as stored and " + orientation_text(color.orientation) +
            ", as its EXIF orientation says: it is taken as stored; if the map is of the picture as "
            "it is seen, save the picture again without that orientation");
    return done;
}

}  // namespace hexrelief::readers
