// What the pictures of a HEIC file are put together from.
#pragma once

#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

// libheif 1.15 decodes a picture of a picture of a picture as deep as the file says, and for ever where one
// is made of itself. Throws Error(input) where item references (ISO/IEC 14496-12, 8.11.12) go more than 8
// deep (phones' go 3: tone map, grid, tile), or a picture is put together from more than 16,384.
void check_derivations(const SourceFile& source);

}  // namespace hexrelief::readers::codec
