// Reads YAML and JSON, which yaml-cpp reads as YAML, and XML, into entries.

#include <yaml-cpp/yaml.h>

#include "pipeline/readers/cameras/entries.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

constexpr int kDeepestElement = 32;

class XmlReader {
  public:
    explicit XmlReader(const CalibrationText& source) : source_(source), text_(trim(source.text)) {}

    // Returns the children of the outermost element as a map.
    YAML::Node read() {
        skip_prolog();
        std::string name;
        return read_element(name, 0);
    }

  private:
    [[noreturn]] void refuse_xml() const {
        refuse_key(source_, "the XML", "is damaged or truncated; save the calibration again");
    }

    std::string_view until(std::string_view end) {
        const std::size_t at = text_.find(end);
        if (at == std::string_view::npos) refuse_xml();
        const std::string_view taken = text_.substr(0, at);
        text_.remove_prefix(at + end.size());
        return taken;
    }

    // Skips white space, comments, <?xml ...?> and <!DOCTYPE ...>.
    void skip_prolog() {
        for (;;) {
            text_ = trim(text_);
            if (text_.starts_with("<!--"))
                until("-->");
            else if (text_.starts_with("<?"))
                until("?>");
            else if (text_.starts_with("<!"))
                until(">");
            else
                return;
        }
    }

    static std::string name_of(std::string_view tag) {
        const std::size_t at = tag.find("name");
        const std::size_t open = at == std::string_view::npos ? at : tag.find_first_of("\"'", at);
        const std::size_t close = open == std::string_view::npos ? open : tag.find(tag[open], open + 1);
        if (close != std::string_view::npos) return std::string(tag.substr(open + 1, close - open - 1));
        return std::string(tag.substr(0, tag.find_first_of(" \t\r\n/")));
    }

    static YAML::Node words_of(std::string_view text) {
        const std::vector<std::string_view> parts = words(text);
        if (parts.size() <= 1) return YAML::Node(std::string(trim(text)));
        YAML::Node list(YAML::NodeType::Sequence);
        for (const std::string_view part : parts) list.push_back(std::string(part));
        return list;
    }

    YAML::Node read_element(std::string& name, int depth) {
        if (depth > kDeepestElement || !text_.starts_with('<')) refuse_xml();
        text_.remove_prefix(1);
        const std::string_view tag = until(">");
        name = name_of(tag);
        if (tag.empty() || name.empty()) refuse_xml();
        YAML::Node map(YAML::NodeType::Map), list(YAML::NodeType::Sequence);
        if (tag.ends_with('/')) return map;
        const std::string end = "</" + std::string(tag.substr(0, tag.find_first_of(" \t\r\n"))) + ">";
        std::string_view text;
        for (;;) {
            const std::size_t next = text_.find('<');
            if (next == std::string_view::npos) refuse_xml();
            if (text.empty()) text = trim(text_.substr(0, next));
            text_.remove_prefix(next);
            skip_prolog();
            if (text_.starts_with("</")) break;
            std::string child_name;
            const YAML::Node child = read_element(child_name, depth + 1);
            if (child_name == "_" || child_name == "value")
                list.push_back(child);
            else
                map.force_insert(child_name, child);
        }
        if (!text_.starts_with(end)) refuse_xml();
        text_.remove_prefix(end.size());
        if (map.size() > 0) return map;
        if (list.size() > 0) return list;
        // A matrix has a list even for one number.
        const YAML::Node value = words_of(text);
        if (name != "data" || value.IsSequence()) return value;
        list.push_back(value);
        return list;
    }

    const CalibrationText& source_;
    std::string_view text_;
};

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

Entries xml_entries(const CalibrationText& source) {
    if (!trim(source.text).starts_with('<')) return {};
    return entries_of_tree(source, XmlReader(source).read());
}

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
