// What a picture or map may be as large as, whoever made it.
#pragma once

namespace hexrelief::readers {

inline constexpr long long kMaxPixels = 1LL << 29;  // 536 Mpx: 16384 x 16384 twice over

struct ReaderLimits {
    long long max_pixels = kMaxPixels;  // 1 .. kMaxPixels
    // What errors name: the key, or the option, of those who call.
    const char* max_pixels_option = "limits.max_pixels";
};

}  // namespace hexrelief::readers
