// The optional edge-preserving filter. It is in a library of its own, loaded only if the filter is used,
// because OpenCV's ximgproc brings in 140 libraries, which would cost each start of the program 0.05-0.17
// s and 50 MB.
#pragma once

#include <cstdint>

namespace hexrelief::stages {

// The arguments of the library's function, in plain C types. Disparities are row-major, in 1/16 px.
// `right` follows OpenCV's convention for right views: disparities are negated. All arrays have
// width * height entries.
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
    std::int16_t* filtered;       // result
    char* message;                // result: the reason if the call fails
    int message_bytes;
};
using WlsFunction = int (*)(const WlsRequest*);  // 0 = done
inline constexpr const char* kWlsFunctionName = "hexrelief_wls_filter";
inline constexpr const char* kWlsLibraryName = "hexrelief-wls.so";

// Runs the filter. The library is loaded on the first call, by open_module(). Throws Error(usage) if it
// is missing or fails.
void filter_wls(const WlsRequest& request);

}  // namespace hexrelief::stages
