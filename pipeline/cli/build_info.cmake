# Versions for `hexrelief --version --verbose`. Included after all rooms, because each room finds its own libraries.
set(HEXRELIEF_COMMIT "" CACHE STRING "Commit that the program names; empty = git's")
if(NOT HEXRELIEF_COMMIT)
    find_program(HEXRELIEF_GIT git)
    mark_as_advanced(HEXRELIEF_GIT)
    set(HEXRELIEF_COMMIT unknown)
    if(HEXRELIEF_GIT AND EXISTS ${PROJECT_SOURCE_DIR}/.git)
        execute_process(COMMAND ${HEXRELIEF_GIT} -C ${PROJECT_SOURCE_DIR} describe --always --dirty --abbrev=12 --exclude=*
            OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
        if(described)
            set(HEXRELIEF_COMMIT ${described})
        endif()
        if(EXISTS ${PROJECT_SOURCE_DIR}/.git/logs/HEAD)  # a new commit is named by the next build
            set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS
                ${PROJECT_SOURCE_DIR}/.git/logs/HEAD)
        endif()
    endif()
endif()

set(cuda "not built in")
if(HEXRELIEF_HAS_CUDA)
    get_directory_property(architectures DIRECTORY ${PROJECT_SOURCE_DIR}/cuda DEFINITION CMAKE_CUDA_ARCHITECTURES)
    get_directory_property(compiler DIRECTORY ${PROJECT_SOURCE_DIR}/cuda DEFINITION CMAKE_CUDA_COMPILER_VERSION)
    list(JOIN architectures " " architectures)
    set(cuda "${compiler}, architectures ${architectures}")
endif()

# A library, the folder whose find_package() found it, and the variable with its version.
set(libraries "")
foreach(entry "draco exporters draco_VERSION" "libjpeg exporters JPEG_VERSION" "libpng exporters PNG_VERSION_STRING"
    "libtiff pipeline/readers TIFF_VERSION_STRING" "meshoptimizer exporters meshoptimizer_VERSION"
    "nlohmann_json exporters nlohmann_json_VERSION" "OpenMesh pipeline/stages OpenMesh_VERSION"
    "yaml-cpp pipeline yaml-cpp_VERSION" "zlib pipeline/readers/depth ZLIB_VERSION_STRING")
    string(REPLACE " " ";" entry ${entry})
    list(POP_FRONT entry name folder variable)
    get_directory_property(version DIRECTORY ${PROJECT_SOURCE_DIR}/${folder} DEFINITION ${variable})
    if(version)
        list(APPEND libraries "${name} ${version}")
    endif()
endforeach()
# OpenCV's three libraries are found without its CMake files, so the version comes from a header.
get_directory_property(opencv DIRECTORY ${PROJECT_SOURCE_DIR}/pipeline/stages DEFINITION HEXRELIEF_OPENCV_INCLUDE)
file(STRINGS ${opencv}/opencv2/core/version.hpp parts REGEX "define CV_VERSION_(MAJOR|MINOR|REVISION) ")
string(REGEX REPLACE "[^0-9;]" "" parts "${parts}")
list(JOIN parts "." parts)
list(APPEND libraries "OpenCV ${parts}")
list(JOIN libraries ", " libraries)
configure_file(${CMAKE_CURRENT_LIST_DIR}/build_info.h.in ${PROJECT_BINARY_DIR}/include/hexrelief_build_info.h @ONLY)
