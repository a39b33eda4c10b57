#include "exporters/viewer/viewer_page.h"

// Embeds a file as bytes between two symbols. The assembler reads it; as an array in C++ it would cost the
// compiler a gigabyte of memory.
#define HEXRELIEF_EMBED(symbol, file)                                                       \
    asm(".pushsection .rodata\n"                                                            \
        ".hidden " #symbol ", " #symbol                                                     \
        "_end\n"                                                                            \
        ".global " #symbol ", " #symbol "_end\n" #symbol ": .incbin \"" file "\"\n" #symbol \
        "_end: .byte 0\n"                                                                   \
        ".popsection\n");                                                                   \
    extern "C" const char symbol[], symbol##_end[]  // NOLINT(bugprone-macro-parentheses): a declared name

#ifdef HEXRELIEF_PAGES
HEXRELIEF_EMBED(hexrelief_viewer_page, HEXRELIEF_PAGES "/page.html");
HEXRELIEF_EMBED(hexrelief_empty_gallery, HEXRELIEF_PAGES "/gallery.html");
#endif

namespace hexrelief::exporters {
#ifdef HEXRELIEF_PAGES

std::string_view viewer_page() {
    return {hexrelief_viewer_page, hexrelief_viewer_page_end};
}

std::string_view empty_gallery() {
    return {hexrelief_empty_gallery, hexrelief_empty_gallery_end};
}

#else

std::string_view viewer_page() {
    return {};
}

std::string_view empty_gallery() {
    return {};
}

#endif
}  // namespace hexrelief::exporters
