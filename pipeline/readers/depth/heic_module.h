// The interface of the library that reads HEIC's pictures and their auxiliary depths. It is opened when
// needed, because libheif brings in codecs that every start of the program would pay for.
#pragma once

#include <cstddef>
#include <cstdint>

namespace hexrelief::readers::codec {

// The arguments and results of the library's function, in plain C types.
struct HeicRequest {
    const std::uint8_t* bytes;
    std::size_t byte_count;
    std::uint32_t item;  // the picture's number in the file; 0 = the primary one
    int of_depth;        // 0 = the picture, interleaved red green blue; 1 = its auxiliary depths, one channel
    int header_only;     // 1 = no samples
    long long most_pixels;
    // Called once with the size of all samples, which are stored row after row; samples of more than 8 bits
    // have 16 bits in the machine's byte order. The returned memory remains the caller's.
    std::uint8_t* (*allocate)(void* user, std::size_t bytes);
    void* user;
    void* profile_user;  // given to allocate() for a picture's colour profile, if it has one

    int width, height, bits;  // result
    // Results from the representation information of depths; numbers that it lacks are NaN.
    int representation;  // 0 = 1 / Z, 1 = disparity, 2 = Z, 3 = non-uniform disparity; -1 = unknown
    double z_near, z_far;
    char* xmp;  // result for depths: their XMP packet, zero-terminated, cut to xmp_bytes
    std::size_t xmp_bytes;
    char* message;  // result: the reason if the call fails
    std::size_t message_bytes;
};
using HeicFunction = int (*)(HeicRequest*);  // returns 0 if it succeeds
inline constexpr const char* kHeicFunctionName = "hexrelief_read_heic";
inline constexpr const char* kHeicLibraryName = "hexrelief-heif.so";

}  // namespace hexrelief::readers::codec
