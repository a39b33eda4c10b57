# The standard library's headers take longer to read than most sources: read once for all libraries with the same options.
# No header of the project is among them: the compiler still notices where one of those is missing, and StandardIncludes
# (tests/house) where a standard one is.
set(standard_headers <algorithm> <array> <atomic> <cmath> <cstdint> <cstring> <filesystem> <fstream> <functional> <limits> <map>
    <memory> <numeric> <optional> <set> <sstream> <stdexcept> <string> <string_view> <thread> <utility> <variant> <vector>)

# precompile_headers(NAME OPTIONS...): a target whose headers others can reuse.
function(precompile_headers name)
    file(CONFIGURE OUTPUT ${name}.cpp CONTENT "")
    add_library(${name} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
    target_link_libraries(${name} PRIVATE hexrelief_options ${ARGN})
    target_precompile_headers(${name} PRIVATE ${standard_headers})
endfunction()
precompile_headers(headers_of_slow_rooms)
precompile_headers(headers_of_mesher hexrelief_mesher_options)
precompile_headers(headers_of_quick_rooms hexrelief_compiled_quickly)

function(reuse_headers folder)
    get_directory_property(targets DIRECTORY ${folder} BUILDSYSTEM_TARGETS)
    foreach(target ${targets})
        get_target_property(type ${target} TYPE)
        get_target_property(libraries ${target} LINK_LIBRARIES)
        if(NOT type STREQUAL "STATIC_LIBRARY")
            continue()
        elseif(hexrelief_mesher_options IN_LIST libraries)
            target_precompile_headers(${target} REUSE_FROM headers_of_mesher)
        elseif(hexrelief_compiled_quickly IN_LIST libraries)
            target_precompile_headers(${target} REUSE_FROM headers_of_quick_rooms)
        else()
            target_precompile_headers(${target} REUSE_FROM headers_of_slow_rooms)
        endif()
    endforeach()
    get_directory_property(folders DIRECTORY ${folder} SUBDIRECTORIES)
    foreach(inner ${folders})
        if(NOT inner MATCHES "/pipeline/matching$")  # options of its own
            reuse_headers(${inner})
        endif()
    endforeach()
endfunction()
reuse_headers(${PROJECT_SOURCE_DIR})
