#include "pipeline/readers/color_profile.h"

#include <lcms2.h>

#include <algorithm>
#include <cstdlib>
#include <memory>

namespace hexrelief::readers {
namespace {

struct Close {
    void operator()(void* profile) const { cmsCloseProfile(profile); }
};
struct Delete {
    void operator()(void* transform) const { cmsDeleteTransform(transform); }
};
using Profile = std::unique_ptr<void, Close>;
using Transform = std::unique_ptr<void, Delete>;

// Returns sRGB, or greys of sRGB's curve (IEC 61966-2-1).
Profile srgb(bool is_grey) {
    if (!is_grey) return Profile(cmsCreate_sRGBProfile());
    const double curve[] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
    cmsToneCurve* const tones = cmsBuildParametricToneCurve(nullptr, 4, curve);
    Profile profile(cmsCreateGrayProfile(cmsD50_xyY(), tones));
    cmsFreeToneCurve(tones);
    return profile;
}

// Returns colours from all over the cube, or all greys.
std::vector<std::uint8_t> probes(bool is_grey) {
    constexpr int kStep = 15;
    std::vector<std::uint8_t> samples;
    const auto add = [&samples](int sample) { samples.push_back(static_cast<std::uint8_t>(sample)); };
    for (int i = 0; is_grey && i < 256; ++i) add(i);
    for (int r = 0; !is_grey && r < 256; r += kStep)
        for (int g = 0; g < 256; g += kStep)
            for (int b = 0; b < 256; b += kStep) {
                add(r);
                add(g);
                add(b);
            }
    return samples;
}

// False if samples change by no more than profiles of sRGB from different programs differ.
bool changes_colors(void* transform, int channels) {
    constexpr int kRounding = 2;
    const std::vector<std::uint8_t> samples = probes(channels == 1);
    std::vector<std::uint8_t> converted(samples.size());
    cmsDoTransform(transform, samples.data(), converted.data(),
                   static_cast<cmsUInt32Number>(samples.size() / channels));
    return !std::ranges::equal(samples, converted, [](int a, int b) { return std::abs(a - b) <= kRounding; });
}

}  // namespace

void to_srgb(Image& image, const std::vector<std::uint8_t>& profile) {
    if (profile.empty() || profile.size() > kLongestProfile) return;
    const bool is_grey = image.channels == 1;
    const Profile from(cmsOpenProfileFromMem(profile.data(), static_cast<cmsUInt32Number>(profile.size())));
    if (!from || cmsGetColorSpace(from.get()) != (is_grey ? cmsSigGrayData : cmsSigRgbData)) return;
    const Profile to = srgb(is_grey);
    const cmsUInt32Number format = is_grey ? TYPE_GRAY_8 : TYPE_RGB_8;
    const Transform transform(
        cmsCreateTransform(from.get(), format, to.get(), format, INTENT_RELATIVE_COLORIMETRIC, 0));
    if (!transform || !changes_colors(transform.get(), image.channels)) return;
    for (int y = 0; y < image.height; ++y)
        cmsDoTransform(transform.get(), image.at(0, y), image.at(0, y),
                       static_cast<cmsUInt32Number>(image.width));
}

}  // namespace hexrelief::readers
