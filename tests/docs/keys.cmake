# cmake -DPROGRAM=P -DREADME=R [-DUPDATE=ON] -P readme_keys.cmake: fails where what stands between the two markers in R is not
# what P prints; with UPDATE writes it there instead.
set(begin "<!-- config keys: written by `hexrelief config show --markdown` -->\n")
set(end "<!-- end of config keys -->")

execute_process(COMMAND ${PROGRAM} config show --markdown OUTPUT_VARIABLE keys RESULT_VARIABLE code)
if(NOT code EQUAL 0 OR NOT keys MATCHES "mesh\\.spacing_px")
    message(FATAL_ERROR "${PROGRAM} config show --markdown exited with ${code} and printed: ${keys}")
endif()

file(READ "${README}" text)
string(FIND "${text}" "${begin}" from)
string(FIND "${text}" "${end}" to)
if(from EQUAL -1 OR to LESS from)
    message(FATAL_ERROR "${README}: the two marker lines around the configuration keys are missing")
endif()
string(LENGTH "${begin}" length)
math(EXPR from "${from} + ${length}")
string(SUBSTRING "${text}" 0 ${from} head)
string(SUBSTRING "${text}" ${to} -1 tail)
if(text STREQUAL "${head}${keys}${tail}")
    return()
endif()
if(NOT UPDATE)
    message(FATAL_ERROR "${README}: the table of configuration keys is out of date; "
        "write it anew with: cmake --build BUILD_FOLDER --target update_readme")
endif()
file(WRITE "${README}" "${head}${keys}${tail}")
