// HEIC's pictures and their auxiliary depths are read by a library that is opened at need: libheif brings in
// codecs that every start of the program would pay for.
#pragma once

#include <cstddef>
#include <cstdint>

namespace hexrelief::readers::codec {

// Everything that crosses into the library, in plain C types.
struct HeicRequest {
    const std::uint8_t* bytes;
    std::size_t byte_count;
    int of_depth;     // 0 = the picture: interleaved red green blue; 1 = its auxiliary depths: one channel
    int header_only;  // 1 = no samples
    long long most_pixels;
    // Called once, with the number of bytes of all samples, rows one after the other; 16-bit ones in the
    // machine's order where bits is above 8. The memory that it gives stays the caller's.
    std::uint8_t* (*allocate)(void* user, std::size_t bytes);
    void* user;

    int width, height, bits, has_depth;  // out
    // Out, of depths, from their representation information; the numbers are NaN where it does not say them.
    int representation;  // 0 = 1 / Z, 1 = disparity, 2 = Z, 3 = disparity not evenly; -1 = not said
    double z_near, z_far, d_min, d_max;
    char* xmp;  // out, of depths: their XMP packet, cut to xmp_bytes with the 0 at its end
    std::size_t xmp_bytes;
    char* message;  // out, where the call fails: why
    std::size_t message_bytes;
};
using HeicFunction = int (*)(HeicRequest*);  // 0 = done
inline constexpr const char* kHeicFunctionName = "hexrelief_read_heic";
inline constexpr const char* kHeicLibraryName = "hexrelief-heif.so";

}  // namespace hexrelief::readers::codec
