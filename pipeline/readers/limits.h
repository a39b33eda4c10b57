// Limits on the size of pictures and maps.
#pragma once

namespace hexrelief::readers {

inline constexpr long long kMaxPixels = 1LL << 29;  // 536 Mpx: 16384 x 16384 twice over

struct ReaderLimits {
    long long max_pixels = kMaxPixels;  // 1 .. kMaxPixels
    // The key, or the option of the caller, that errors name.
    const char* max_pixels_option = "limits.max_pixels";
};

}  // namespace hexrelief::readers
