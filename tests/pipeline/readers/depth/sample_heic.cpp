// libheif writes no depths, but it writes alpha as an auxiliary image, whose type is then changed to depths.
#include <libheif/heif.h>

#include <algorithm>
#include <string_view>

#include "tests/pipeline/readers/depth/sample_maps.h"

// libx265, which encodes the samples, leaks some memory.
// NOLINTNEXTLINE(bugprone-reserved-identifier): LeakSanitizer's name
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libx265";
}

namespace hexrelief::readers {
namespace {

heif_error take(heif_context*, const void* data, size_t size, void* user) {
    const auto* const bytes = static_cast<const std::uint8_t*>(data);
    *static_cast<Bytes*>(user) = Bytes(bytes, bytes + size);
    return {heif_error_Ok, heif_suberror_Unspecified, "written"};
}

Bytes::iterator find_text(Bytes& bytes, std::string_view text) {
    return std::search(bytes.begin(), bytes.end(), text.begin(), text.end());
}

// Turns the alpha into depths: changes its type, and the XMP's reference, which libheif makes to the picture.
void make_depths_of_alpha(Bytes& file) {
    constexpr std::string_view alpha = "urn:mpeg:hevc:2015:auxid:1";
    const auto type = find_text(file, alpha), auxiliary = find_text(file, "auxl"),
               described = find_text(file, "cdsc");
    if (type == file.end() || auxiliary == file.end()) return;
    type[alpha.size() - 1] = '2';
    if (described != file.end()) std::copy_n(auxiliary + 4, 2, described + 8);
}

// Increases the big-endian number of four bytes at `at`.
void add_to_number(Bytes::iterator at, std::size_t more) {
    std::size_t number = 0;
    for (int i = 0; i < 4; ++i) number = number << 8 | at[i];
    number += more;
    for (int i = 4; i-- > 0; number >>= 8) at[i] = static_cast<std::uint8_t>(number);
}

// Encodes pictures of one size, red green blue and perhaps alpha; the XMP packet belongs to each. Empty if
// libheif has no encoder.
Bytes encoded(int width, int height, const std::vector<Bytes>& pictures, const std::string& xmp,
              const Bytes& profile = {}) {
    Bytes file;
    heif_context* const context = heif_context_alloc();
    heif_encoder* encoder = nullptr;
    if (heif_context_get_encoder_for_format(context, heif_compression_HEVC, &encoder).code == heif_error_Ok) {
        heif_encoder_set_lossless(encoder, 1);
        const std::size_t channels = pictures[0].size() / (static_cast<std::size_t>(width) * height);
        for (const Bytes& pixels : pictures) {
            heif_image* image = nullptr;
            heif_image_create(width, height, heif_colorspace_RGB,
                              channels == 4 ? heif_chroma_interleaved_RGBA : heif_chroma_interleaved_RGB,
                              &image);
            heif_image_add_plane(image, heif_channel_interleaved, width, height, 8);
            int stride = 0;
            std::uint8_t* const plane = heif_image_get_plane(image, heif_channel_interleaved, &stride);
            const std::size_t row = channels * width;
            for (int y = 0; y < height; ++y)
                std::copy_n(pixels.data() + row * y, row, plane + static_cast<std::ptrdiff_t>(stride) * y);
            if (!profile.empty())
                heif_image_set_raw_color_profile(image, "prof", profile.data(), profile.size());
            heif_image_handle* handle = nullptr;
            heif_context_encode_image(context, image, encoder, nullptr, &handle);
            if (!xmp.empty())
                heif_context_add_XMP_metadata(context, handle, xmp.data(), static_cast<int>(xmp.size()));
            heif_image_handle_release(handle);
            heif_image_release(image);
        }
        heif_writer writer{1, take};
        heif_context_write(context, &writer, &file);
        heif_encoder_release(encoder);
    }
    heif_context_free(context);
    return file;
}

}  // namespace

Bytes make_heic_pair(std::array<std::uint8_t, 3> left, std::array<std::uint8_t, 3> right) {
    constexpr int kSide = 64;
    std::vector<Bytes> pictures(2);
    for (int i = 0; i < kSide * kSide; ++i) {
        pictures[0].insert(pictures[0].end(), left.begin(), left.end());
        pictures[1].insert(pictures[1].end(), right.begin(), right.end());
    }
    Bytes file = encoded(kSide, kSide, pictures, "");
    if (file.empty()) return file;
    // A list of groups with one stereo pair, number 9: the second picture is the left one.
    const Bytes group = {0, 0, 0, 36, 'g', 'r', 'p', 'l', 0, 0, 0, 28, 's', 't', 'e', 'r', 0, 0,
                         0, 0, 0, 0,  0,   9,   0,   0,   0, 2, 0, 0,  0,   2,   0,   0,   0, 1};
    const auto meta = find_text(file, "meta") - 4;
    std::size_t size = 0;
    for (int i = 0; i < 4; ++i) size = size << 8 | meta[i];
    const auto end = meta - file.begin() + static_cast<std::ptrdiff_t>(size);
    add_to_number(meta, group.size());
    const auto items = find_text(file, "iloc") + 10;
    for (int i = 0; i < items[1]; ++i) add_to_number(items + 2 + 18 * i + 10, group.size());
    file.insert(file.begin() + end, group.begin(), group.end());
    return file;
}

Bytes with_representation(Bytes file) {
    // The lengths of all units and of the only one, then H.265's SEI message 177: near and far are
    // given as 1 / Z, 2^-1 and 2^2, each as sign, exponent + 31, length of the mantissa - 1 and mantissa.
    const Bytes message = {0, 0, 0, 14, 0, 0, 0, 10, 0x4e, 1, 177, 5, 0xc8, 0xf0, 0x04, 0x20, 0x40, 0x80};
    const auto auxiliary = find_text(file, "auxC") - 4;
    const auto end = (auxiliary - file.begin()) + auxiliary[3];  // a short box
    for (const char* box : {"auxC", "ipco", "iprp", "meta"})
        add_to_number(find_text(file, box) - 4, message.size());
    // The items follow: version 0, numbers of four bytes, one extent each.
    const auto items = find_text(file, "iloc") + 10;
    for (int i = 0; i < items[1]; ++i) add_to_number(items + 2 + 18 * i + 10, message.size());
    file.insert(file.begin() + end, message.begin(), message.end());
    return file;
}

Bytes make_heic(int width, int height, const Bytes& rgb_and_depth, const std::string& xmp,
                const Bytes& profile) {
    Bytes file = encoded(width, height, {rgb_and_depth}, xmp, profile);
    make_depths_of_alpha(file);
    return file;
}

}  // namespace hexrelief::readers
