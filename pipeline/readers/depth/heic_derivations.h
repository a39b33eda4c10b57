// Checks how the pictures of a HEIC file are derived from each other.
#pragma once

#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

// Throws Error(input) if item references (ISO/IEC 14496-12, 8.11.12) are nested more than 8 deep (phones use
// 3: tone map, grid, tile), or if a picture is put together from more than 16,384 others. libheif 1.15
// decodes nested pictures to any depth that the file asks for, and endlessly if one is derived from itself.
void check_derivations(const SourceFile& source);

}  // namespace hexrelief::readers::codec
