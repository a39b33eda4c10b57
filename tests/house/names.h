// The names of the house: of namespaces, types and headers.
#pragma once

#include <string>
#include <vector>

#include "tests/house/rooms.h"

namespace hexrelief::testing_house {

// The namespace of a file's room: "hexrelief::matching"; of what all rooms use, "hexrelief".
std::string namespace_of(const std::string& path);

// The namespaces that a file opens, without anonymous and inline ones: "hexrelief::matching".
std::vector<std::string> opened_namespaces(const SourceFile& file);

// The types that a file defines in its namespaces, aliases included, anonymous namespaces apart:
// "hexrelief::matching::Slopes".
std::vector<std::string> defined_types(const SourceFile& file);

// One line each: a type that two files define.
std::vector<std::string> types_defined_twice(const std::vector<SourceFile>& files);

// One line each: a namespace that is not the file's room's.
std::vector<std::string> foreign_namespaces(const SourceFile& file);

// One line each: a header's name that another header has as well. Twins may: the same path in cuda/ and in
// mesher/ or pipeline/.
std::vector<std::string> headers_named_alike(const std::vector<SourceFile>& files);

}  // namespace hexrelief::testing_house
