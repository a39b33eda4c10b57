// The texture that a limit on bytes leaves room for.
#pragma once

#include <functional>
#include <vector>

namespace hexrelief::budget {

struct TextureChoice {
    int max_px = 0;  // of the longest side; 0 = as large as it is
    int quality = 90;
};

struct TextureLimits {
    TextureChoice configured;
    int longest_px = 0;  // the longest side as configured
    bool may_shrink = true, may_lose_quality = true;
};

// From the configured texture on, each with fewer bytes than the one before: at its size in steps of 10 down
// to a quality of 50, then again and again with sides 0.71 times as long, at 70 and 50, down to 32 px.
std::vector<TextureChoice> texture_choices(const TextureLimits& limits);

// The first that takes at most `share` of `max_bytes`; the last where none does. Asks for the bytes of some,
// which are taken to fall from one choice to the next.
TextureChoice choose_texture(const TextureLimits& limits, double max_bytes, double share,
                             const std::function<double(const TextureChoice&)>& bytes);

}  // namespace hexrelief::budget
