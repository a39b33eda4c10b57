// The light of a texture that is taken from elsewhere.
#pragma once

#include "pipeline/stages/other_views/texture_level.h"

namespace hexrelief::stages {

// Sets the level's `light` so that at seams, between targets of different offsets and beside what is seen of
// their surface, the colours go on as they do at the sources, and that it is smooth elsewhere (Perez et al.
// 2003). coarser: the level whose light it begins with; none = no light. The same for any number of threads.
void match_light(TextureLevel& level, const TextureLevel* coarser, ThreadPool& pool);

}  // namespace hexrelief::stages
