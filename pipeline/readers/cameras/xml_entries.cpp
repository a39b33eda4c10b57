// Reads the XML of OpenCV's FileStorage and of RealSense's calibration tool: nested elements, of which a
// "name" names the element, and a list is repeated children "_" or "value", or words.
#include <yaml-cpp/yaml.h>

#include <optional>

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

    // Reads one element; `name` receives its name.
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

}  // namespace

Entries xml_entries(const CalibrationText& source) {
    if (!trim(source.text).starts_with('<')) return {};
    return entries_of_tree(source, XmlReader(source).read());
}

}  // namespace hexrelief::readers::codec
