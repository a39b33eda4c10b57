// Keys of earlier versions.
#pragma once

#include <string>
#include <vector>

namespace hexrelief::config {

struct RenamedKey {
    const char *path, *now;
};
// Returns the keys that only changed their name: the old name is still read, with a warning.
const std::vector<RenamedKey>& renamed_keys();

// Returns the present name of a renamed key; empty if the key was not renamed.
std::string new_name(const std::string& path);

// Returns the present text of a key's former value; other texts unchanged.
std::string current_value(const std::string& path, const std::string& text);

// Returns "; it is now ..." for a key that is no longer read because its values changed too, else empty.
std::string moved_key(const std::string& path);

// Returns the warning for a key that is given by its old name.
std::string renamed_key_warning(const std::string& path);

}  // namespace hexrelief::config
