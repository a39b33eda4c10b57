// The optional edge-preserving filter, which lives in a library of its own that is loaded only when asked
// for: OpenCV's ximgproc brings in 140 libraries, 0.05-0.17 s and 50 MB, which every start of the program
// would pay.
#pragma once

#include <cstdint>

namespace hexrelief::stages {

// Everything that crosses into the library, in plain C types. Disparities are row-major, 1/16 px. `right`
// follows OpenCV's convention for right views: disparities negated. All arrays have width * height entries.
struct WlsRequest {
    int width;
    int height;
    int channels;
    const std::uint8_t* guide;  // the left image, width * height * channels
    const std::int16_t* left;
    const std::int16_t* right;
    double lambda;
    double sigma;
    int discontinuity_radius_px;  // pixels this near a depth edge are trusted less
    std::int16_t* filtered;       // out
    char* message;                // out, where the call fails: why
    int message_bytes;
};
using WlsFunction = int (*)(const WlsRequest*);  // 0 = done
inline constexpr const char* kWlsFunctionName = "hexrelief_wls_filter";
inline constexpr const char* kWlsLibraryName = "hexrelief-wls.so";

// Finds the library beside the program, in ../lib/hexrelief or ../lib from there, or in such places from the
// shared library that this is a part of; loads it once and runs it.
// Throws Error(usage) where it is missing or fails.
void filter_wls(const WlsRequest& request);

}  // namespace hexrelief::stages
