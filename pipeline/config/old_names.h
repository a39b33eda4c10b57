// Keys of earlier versions.
#pragma once

#include <string>
#include <vector>

namespace hexrelief::config {

struct RenamedKey {
    const char *path, *now;
};
// Keys that only got another name: the old one is still read, with a warning.
const std::vector<RenamedKey>& renamed_keys();

// The name that such a key has now; else empty.
std::string new_name(const std::string& path);

// The text that a key's former value has now; else the text itself.
std::string current_value(const std::string& path, const std::string& text);

// "; it is now ..." for a key that is no longer read because its values changed too. Else empty.
std::string moved_key(const std::string& path);

// What is told of a key that is still read by its old name.
std::string renamed_key_warning(const std::string& path);

}  // namespace hexrelief::config
