# cmake -DPROGRAM=P -DKEYS=K [-DUPDATE=ON] -P keys.cmake: fails where K is not what `P config show --markdown` prints; with
# UPDATE writes it there instead.
execute_process(COMMAND ${PROGRAM} config show --markdown OUTPUT_VARIABLE keys RESULT_VARIABLE code)
if(NOT code EQUAL 0 OR NOT keys MATCHES "mesh\\.spacing_px")
    message(FATAL_ERROR "${PROGRAM} config show --markdown exited with ${code} and printed: ${keys}")
endif()
if(UPDATE)
    file(WRITE "${KEYS}" "${keys}")
    return()
endif()
if(NOT EXISTS "${KEYS}")
    message(FATAL_ERROR "${KEYS} is missing")
endif()
file(READ "${KEYS}" text)
if(NOT text STREQUAL keys)
    message(FATAL_ERROR "${KEYS} is out of date; "
        "write it anew with: cmake --build BUILD_FOLDER --target update_keys")
endif()
