#include "pipeline/readers/codecs.h"

#include <algorithm>
#include <array>

#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

using Head = std::span<const std::uint8_t>;
constexpr std::size_t kHeadBytes = 16;

bool begins(Head head, std::string_view magic, std::size_t at = 0) {
    return head.size() >= at + magic.size() &&
           std::equal(magic.begin(), magic.end(), head.begin() + at,
                      [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

// The letters "P5" might begin any text, so a white space or a comment must follow.
bool netpbm_kind(Head head, std::string_view kinds) {
    return head.size() >= 3 && head[0] == 'P' &&
           kinds.find(static_cast<char>(head[1])) != std::string_view::npos &&
           (is_space(head[2]) || head[2] == '#');
}

// The letters "BM" might begin any text, so the length of the second header must be a known one.
bool is_bmp(Head head) {
    constexpr std::string_view lengths = "\x0c\x28\x34\x38\x40\x6c\x7c";
    return begins(head, "BM") && head.size() >= 16 && head[15] == 0 &&
           lengths.find(static_cast<char>(head[14])) != std::string_view::npos;
}
bool is_zip(Head head) {
    using namespace std::string_view_literals;
    return begins(head, "PK\3\4"sv) || begins(head, "PK\5\6"sv);
}
bool is_heic(Head head) {
    return begins(head, "ftyp", 4) && (begins(head, "hei", 8) || begins(head, "hev", 8) ||
                                       begins(head, "mif1", 8) || begins(head, "msf1", 8));
}
bool is_tiff(Head head) {
    using namespace std::string_view_literals;
    return begins(head, "II*\0"sv) || begins(head, "MM\0*"sv) || begins(head, "II+\0"sv) ||
           begins(head, "MM\0+"sv);
}

constexpr unsigned kEither = kPicture | kMap | kConfidence, kMaps = kMap | kConfidence;
// In the order in which a folder's files of one name are preferred.
constexpr std::array<Codec, 12> kCodecs{{
    {Format::png, "PNG", ".png", kEither | kBothViews | kCamera,
     [](Head head) { return begins(head, "\x89PNG\r\n\x1a\n"); }, describe_png, decode_png},
    {Format::jpeg, "JPEG", ".jpg .jpeg", kPicture | kBothViews | kCamera,
     [](Head head) { return begins(head, "\xff\xd8\xff"); }, describe_jpeg, decode_jpeg},
    {Format::pnm, "PGM/PPM", ".ppm .pgm .pnm", kEither, [](Head head) { return netpbm_kind(head, "56"); },
     describe_pnm, decode_pnm},
    {Format::tiff, "TIFF", ".tif .tiff", kEither, is_tiff, describe_tiff, decode_tiff},
    {Format::webp, "WebP", ".webp", kPicture | kCamera,
     [](Head head) { return begins(head, "RIFF") && begins(head, "WEBP", 8); }, describe_webp, decode_webp},
    {Format::heic, "HEIC", ".heic .heif", kPicture | kBothViews | kMap | kCamera, is_heic, describe_heic,
     decode_heic},
    {Format::bmp, "BMP", ".bmp", kEither, is_bmp, describe_bmp, decode_bmp},
    {Format::exr, "EXR", ".exr", kEither, [](Head head) { return begins(head, "\x76\x2f\x31\x01"); },
     describe_exr, decode_exr, list_exr},
    {Format::pfm, "PFM", ".pfm", kMaps, [](Head head) { return netpbm_kind(head, "fF"); }, describe_pfm,
     decode_pfm},
    {Format::npy, "NPY", ".npy", kMaps | kCamera, [](Head head) { return begins(head, "\x93NUMPY"); },
     describe_npy, decode_npy},
    {Format::npz, "NPZ", ".npz", kMaps | kCamera, is_zip, describe_npz, decode_npz, list_npz},
    {Format::float_map, "COLMAP's, OpenMVS's or Sintel's", ".bin .dmap .dpt .flo", kMap, is_float_map,
     describe_float_map, decode_float_map},
}};

const Codec* match(Head head) {
    for (const Codec& codec : kCodecs)
        if (codec.recognises(head)) return &codec;
    return nullptr;
}

// Files that are told by name, because another program can save them as one that is read.
struct Unread {
    std::string_view magic;
    const char* told;
    std::size_t at = 0;
};
constexpr Unread kUnread[] = {
    {"\x89HDF\r\n", "it is HDF5 (.h5, .dsp5, newer .mat), which is not read; save its data set as NPY"},
    {"MATLAB", "it is MATLAB's .mat, which is not read; save the array as NPY"},
    {"\x1f\x8b", "it is packed by gzip; unpack it first"},
    {"ply\n", "it is a PLY mesh or point cloud, not a map"},
    {"# .PCD", "it is a point cloud, not a map"},
    {"GIF8", "it is a GIF, whose palette holds no map"},
    {"ftypavif", "it is AVIF, which is not read", 4},
    {"jP  \r\n\x87\n", "it is JPEG 2000, which is not read", 4},
    {"JXL \r\n\x87\n", "it is JPEG XL, which is not read", 4},
    {"\xff\x0a", "it is JPEG XL, which is not read"},
    {"\x80\2", "it is a Python pickle, which is not read; save the array by numpy.save"},
    {"\x80\3", "it is a Python pickle, which is not read; save the array by numpy.save"},
    {"\x80\4", "it is a Python pickle, which is not read; save the array by numpy.save"},
    {"\x80\5", "it is a Python pickle, which is not read; save the array by numpy.save"},
};

std::string looks_like(Head head) {
    for (const Unread& unread : kUnread)
        if (begins(head, unread.magic, unread.at)) return unread.told;
    if (head.empty()) return "the file is empty";
    if (netpbm_kind(head, "12347"))
        return std::string("Netpbm kind P") + static_cast<char>(head[1]) +
               " is not supported, only binary P5 and P6";
    const bool text =
        std::ranges::all_of(head, [](std::uint8_t c) { return is_space(c) || (c >= 0x20 && c != 0x7f); });
    return text ? "it is text, or an unknown format (a table of numbers is read as NPY: numpy.save of "
                  "numpy.loadtxt)"
                : "its format is not recognised";
}

}  // namespace

const Codec* find_codec(const std::filesystem::path& path) {
    return match(load_head(path, kHeadBytes).bytes);
}

std::span<const Codec> codecs() {
    return kCodecs;
}

std::string names_of(unsigned gives) {
    std::string names;
    for (const Codec& codec : kCodecs)
        if ((codec.gives & gives) != 0) names.append(names.empty() ? "" : ", ").append(codec.name);
    return names;
}

const Codec& require_codec(const std::filesystem::path& path, const std::string& wanted) {
    const SourceFile head = load_head(path, kHeadBytes);
    if (const Codec* codec = match(head.bytes)) return *codec;
    refuse(path, looks_like(head.bytes) + "; give " + wanted);
}

SourceFile load_raster_file(const std::filesystem::path& path, const ReaderLimits& limits) {
    // Room for metadata, and for four channels of doubles, or for three channels of floats
    // in the largest raster.
    const auto pixels = static_cast<std::uintmax_t>(limits.max_pixels);
    constexpr std::uintmax_t most = static_cast<std::uintmax_t>(kMaxPixels) * 12;
    SourceFile source = load_file(path, std::min(pixels * 32, most) + (64u << 20));
    source.limits = limits;
    return source;
}

}  // namespace hexrelief::readers::codec
