// Colour profiles as files hold them, made by Little CMS.
#pragma once

#include <lcms2.h>

#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {

// Returns the profile's bytes, and closes it.
inline Bytes saved_profile(cmsHPROFILE profile) {
    cmsUInt32Number size = 0;
    cmsSaveProfileToMem(profile, nullptr, &size);
    Bytes bytes(size);
    cmsSaveProfileToMem(profile, bytes.data(), &size);
    cmsCloseProfile(profile);
    return bytes;
}

// Returns greys whose light is the sample to this power.
inline Bytes grey_profile(double gamma) {
    cmsToneCurve* const tones = cmsBuildGamma(nullptr, gamma);
    const Bytes bytes = saved_profile(cmsCreateGrayProfile(cmsD50_xyY(), tones));
    cmsFreeToneCurve(tones);
    return bytes;
}

// Returns Display P3, the colours of phones: P3's primaries, white D65, sRGB's curve.
inline Bytes display_p3_profile() {
    const cmsCIExyY white = {0.3127, 0.3290, 1};
    const cmsCIExyYTRIPLE primaries = {{0.680, 0.320, 1}, {0.265, 0.690, 1}, {0.150, 0.060, 1}};
    const double curve[] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
    cmsToneCurve* const tones = cmsBuildParametricToneCurve(nullptr, 4, curve);
    cmsToneCurve* const all[] = {tones, tones, tones};
    const Bytes bytes = saved_profile(cmsCreateRGBProfile(&white, &primaries, all));
    cmsFreeToneCurve(tones);
    return bytes;
}

}  // namespace hexrelief::readers
