// Chooses the texture that a limit on bytes leaves room for.
#pragma once

#include <functional>
#include <vector>

namespace hexrelief::job {

struct TextureChoice {
    int max_px = 0;  // of the longest side; 0 = unlimited
    int quality = 90;
};

struct TextureLimits {
    TextureChoice configured;
    int longest_px = 0;  // longest side of the configured texture
    bool may_shrink = true, may_lose_quality = true;
};

// Returns the choices from the configured texture on, each with fewer bytes than the one before: at the same
// size in steps of 10 down to a quality of 50, then with sides 0.71 times as long each time, at qualities 70
// and 50, down to 32 px.
std::vector<TextureChoice> texture_choices(const TextureLimits& limits);

// Returns the first choice that takes at most `share` of `max_bytes`; the last one if none does. Calls
// bytes() for some choices only; sizes are assumed to fall from one choice to the next.
TextureChoice choose_texture(const TextureLimits& limits, double max_bytes, double share,
                             const std::function<double(const TextureChoice&)>& bytes);

}  // namespace hexrelief::job
