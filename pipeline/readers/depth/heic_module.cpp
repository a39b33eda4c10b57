// The library for HEIC files; the only file that uses libheif.
#include "pipeline/readers/depth/heic_module.h"

#include <libheif/heif.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using hexrelief::readers::codec::HeicRequest;

template <auto release>
struct Releaser {
    template <typename T>
    void operator()(T* object) const {
        release(object);
    }
};
using Context = std::unique_ptr<heif_context, Releaser<heif_context_free>>;
using Handle = std::unique_ptr<heif_image_handle, Releaser<heif_image_handle_release>>;
using Picture = std::unique_ptr<heif_image, Releaser<heif_image_release>>;
using Options = std::unique_ptr<heif_decoding_options, Releaser<heif_decoding_options_free>>;

void check(const heif_error& error) {
    if (error.code != heif_error_Ok) throw std::runtime_error(error.message ? error.message : "damaged");
}

// Returns the picture's auxiliary depths, or null.
Handle depth_of(const heif_image_handle* picture, heif_item_id& id) {
    heif_image_handle* depth = nullptr;
    if (heif_image_handle_get_list_of_depth_image_IDs(picture, &id, 1) != 1) return nullptr;
    check(heif_image_handle_get_depth_image_handle(picture, id, &depth));
    return Handle(depth);
}

void read_representation(const heif_image_handle* picture, heif_item_id id, HeicRequest& request) {
    const heif_depth_representation_info* info = nullptr;
    if (!heif_image_handle_get_depth_image_representation_info(picture, id, &info) || info == nullptr) return;
    request.representation = info->depth_representation_type;
    if (info->has_z_near) request.z_near = info->z_near;
    if (info->has_z_far) request.z_far = info->z_far;
    heif_depth_representation_info_free(info);
}

void read_xmp(const heif_image_handle* depth, HeicRequest& request) {
    heif_item_id id = 0;
    if (heif_image_handle_get_list_of_metadata_block_IDs(depth, "mime", &id, 1) != 1) return;
    std::vector<char> text(std::min<std::size_t>(heif_image_handle_get_metadata_size(depth, id), 1 << 24));
    if (text.size() != heif_image_handle_get_metadata_size(depth, id)) return;
    check(heif_image_handle_get_metadata(depth, id, text.data()));
    const std::size_t count = std::min(text.size(), request.xmp_bytes - 1);
    std::copy_n(text.begin(), count, request.xmp);
    request.xmp[count] = '\0';
}

// Returns the side of a square of most_pixels.
int longest_side(const HeicRequest& request) {
    return static_cast<int>(std::sqrt(static_cast<double>(request.most_pixels)));
}

void check_size(int width, int height, const HeicRequest& request) {
    if (width < 1 || height < 1 || static_cast<long long>(width) * height > request.most_pixels)
        throw std::runtime_error("its size is impossible");
    if (std::max(width, height) > longest_side(request))
        throw std::runtime_error("one of its sides is longer than " + std::to_string(longest_side(request)) +
                                 " px, the square root of limits.max_pixels; scale it down first");
}

void copy_samples(const heif_image_handle* handle, HeicRequest& request) {
    const Options options(heif_decoding_options_alloc());
    options->convert_hdr_to_8bit = request.of_depth ? 0 : 1;
    options->strict_decoding = 1;
    heif_image* decoded = nullptr;
    check(heif_decode_image(
        handle, &decoded, request.of_depth ? heif_colorspace_undefined : heif_colorspace_RGB,
        request.of_depth ? heif_chroma_undefined : heif_chroma_interleaved_RGB, options.get()));
    const Picture picture(decoded);
    const heif_channel channel = !request.of_depth                                 ? heif_channel_interleaved
                                 : heif_image_has_channel(decoded, heif_channel_Y) ? heif_channel_Y
                                                                                   : heif_channel_R;
    int stride = 0;
    const std::uint8_t* const plane = heif_image_get_plane_readonly(decoded, channel, &stride);
    if (plane == nullptr) throw std::runtime_error("it has no samples");
    // The decoded picture is rotated and cropped as the file says, so its size is checked again.
    request.width = heif_image_get_width(decoded, channel);
    request.height = heif_image_get_height(decoded, channel);
    request.bits = request.of_depth ? heif_image_get_bits_per_pixel_range(decoded, channel) : 8;
    check_size(request.width, request.height, request);
    const std::size_t pixel = request.of_depth ? (request.bits > 8 ? 2 : 1) : 3, row = pixel * request.width;
    std::uint8_t* const to = request.allocate(request.user, row * request.height);
    for (int y = 0; y < request.height; ++y)
        std::memcpy(to + row * y, plane + static_cast<std::ptrdiff_t>(stride) * y, row);
}

void read_profile(const heif_image_handle* picture, HeicRequest& request) {
    const std::size_t bytes = heif_image_handle_get_raw_color_profile_size(picture);
    if (bytes == 0 || bytes > request.byte_count) return;
    check(heif_image_handle_get_raw_color_profile(picture, request.allocate(request.profile_user, bytes)));
}

void read(HeicRequest& request) {
    const Context context(heif_context_alloc());
    check(heif_context_read_from_memory_without_copy(context.get(), request.bytes, request.byte_count,
                                                     nullptr));
    heif_image_handle* found = nullptr;
    check(request.item == 0 ? heif_context_get_primary_image_handle(context.get(), &found)
                            : heif_context_get_image_handle(context.get(), request.item, &found));
    const Handle picture(found);
    heif_item_id id = 0;
    const Handle depth = depth_of(picture.get(), id);
    if (request.of_depth && !depth)
        throw std::runtime_error("its picture has no auxiliary depths; only portrait photographs have them");
    const heif_image_handle* const wanted = request.of_depth ? depth.get() : picture.get();
    request.width = heif_image_handle_get_width(wanted);
    request.height = heif_image_handle_get_height(wanted);
    request.bits = heif_image_handle_get_luma_bits_per_pixel(wanted);
    check_size(request.width, request.height, request);
    if (request.of_depth) {
        read_representation(picture.get(), id, request);
        read_xmp(wanted, request);
    }
    // A picture put together from tiles may be larger than the header says. libheif limits its sides, not its
    // pixels; the limit is exclusive.
    heif_context_set_maximum_image_size_limit(context.get(), longest_side(request) + 1);
    // Otherwise each picture made of tiles starts threads of its own, even if it is a tile itself.
    heif_context_set_max_decoding_threads(context.get(), 0);
    if (request.header_only) return;
    copy_samples(wanted, request);
    if (!request.of_depth) read_profile(wanted, request);
}

}  // namespace

extern "C" __attribute__((visibility("default"))) int hexrelief_read_heic(HeicRequest* request) {
    try {
        request->representation = -1;
        request->z_near = request->z_far = std::nan("");
        read(*request);
        return 0;
    } catch (const std::exception& error) {
        std::snprintf(request->message, request->message_bytes, "%s", error.what());
        return 1;
    }
}
