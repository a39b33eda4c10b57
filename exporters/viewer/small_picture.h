// Makes pictures that are small enough to be embedded in a page.
#pragma once

#include <string>

#include "pipeline/data/image.h"

namespace hexrelief::exporters {

// Returns the data: URL of a WebP file of at most about 16 kB, shrunk and compressed as far as needed.
std::string small_picture(const Image& image);

}  // namespace hexrelief::exporters
