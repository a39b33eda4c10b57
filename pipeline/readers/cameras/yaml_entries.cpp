// Reads YAML and JSON, which yaml-cpp reads as YAML, and XML, into entries.
#include <yaml-cpp/yaml.h>

#include <optional>

#include "pipeline/readers/cameras/entries.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

constexpr std::size_t kMostValues = 1u << 18;  // aliases of YAML could ask for any number
constexpr int kDeepestNode = 64;

// Removes FileStorage's first line "%YAML:1.0", which is not a valid YAML directive.
std::string without_directive(const std::string& text) {
    const std::size_t start = text.find_first_not_of(" \t\r\n");
    if (start == std::string::npos || text.compare(start, 5, "%YAML") != 0) return text;
    const std::size_t end = text.find('\n', start);
    return end == std::string::npos ? std::string() : text.substr(end + 1);
}

// Returns the child of the name in any case of its letters; undefined if there is none.
YAML::Node child_of(const YAML::Node& map, const char* name) {
    for (const auto& child : map)
        if (child.first.IsScalar() && plain_name(child.first.Scalar()) == name) return child.second;
    return YAML::Node(YAML::NodeType::Undefined);
}

class TreeReader {
  public:
    explicit TreeReader(const CalibrationText& source) : source_(source) {}

    Entries take() { return std::move(entries_); }

    void read(const YAML::Node& node, const std::string& name, int depth = 0) {
        if (depth > kDeepestNode) refuse_key(source_, excerpt(name), "is nested too deeply");
        if (node.IsScalar()) {
            add(name, {node.Scalar()});
        } else if (node.IsSequence()) {
            read_list(node, name, depth);
        } else if (node.IsMap() && !read_matrix(node, name)) {
            for (const auto& child : node) {
                if (!child.first.IsScalar()) continue;
                const std::string& key = child.first.Scalar();
                read(child.second, name.empty() ? key : name + "." + key, depth + 1);
            }
        }
    }

  private:
    void add(const std::string& name, std::vector<std::string> values) {
        values_ += 1 + values.size();
        if (values_ > kMostValues) refuse_key(source_, "the file", "has too many values for a calibration");
        entries_.push_back({name, std::move(values)});
    }

    // Appends the scalars of nested lists; false if there is anything else in them.
    bool append(const YAML::Node& list, std::vector<std::string>& values, int depth) const {
        if (depth > 4) return false;
        for (const YAML::Node& item : list) {
            if (values.size() > kMostValues) return false;
            if (item.IsScalar())
                values.push_back(item.Scalar());
            else if (!item.IsSequence() || !append(item, values, depth + 1))
                return false;
        }
        return true;
    }

    void read_list(const YAML::Node& list, const std::string& name, int depth) {
        std::vector<std::string> values;
        if (append(list, values, 0)) {
            add(name, std::move(values));
            return;
        }
        std::size_t i = 0;
        for (const YAML::Node& item : list) read(item, name + "." + std::to_string(i++), depth + 1);
    }

    // Reads rows, cols and data as one matrix; false if the map is no matrix.
    bool read_matrix(const YAML::Node& map, const std::string& name) {
        const YAML::Node data = child_of(map, "data"), rows = child_of(map, "rows"),
                         columns = child_of(map, "cols");
        if (!data.IsDefined() || !rows.IsDefined() || !columns.IsDefined()) return false;
        std::vector<std::string> values;
        if (!data.IsSequence() || !append(data, values, 0) || !rows.IsScalar() || !columns.IsScalar() ||
            require_number(source_, name + ".rows", rows.Scalar()) *
                    require_number(source_, name + ".cols", columns.Scalar()) !=
                static_cast<double>(values.size()))
            refuse_key(source_, name, "must hold rows times cols numbers in data");
        add(name, std::move(values));
        return true;
    }

    const CalibrationText& source_;
    Entries entries_;
    std::size_t values_ = 0;
};

}  // namespace

Entries entries_of_tree(const CalibrationText& source, const YAML::Node& root) {
    TreeReader reader(source);
    if (root.IsMap()) reader.read(root, "");
    return reader.take();
}

Entries yaml_entries(const CalibrationText& source) {
    try {
        return entries_of_tree(source, YAML::Load(without_directive(source.text)));
    } catch (const YAML::Exception& failure) {
        const std::string where =
            failure.mark.is_null() ? "" : "line " + std::to_string(failure.mark.line + 1) + ": ";
        refuse_key(source, where + printable(failure.msg, 200) + ";",
                   "it must be a calibration; exporters/FORMATS.md lists those that are known");
    }
}

}  // namespace hexrelief::readers::codec
