// Pictures that are small enough to lie in a page beside its relief.
#pragma once

#include <string>

#include "pipeline/data/image.h"

namespace hexrelief::exporters {

// As a data: address of a WebP file of at most about 16 kB, shrunk and compressed as much as that takes.
std::string small_picture(const Image& image);

}  // namespace hexrelief::exporters
