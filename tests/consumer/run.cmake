# run(COMMAND ...): stops the test, with everything that was printed, unless the command succeeds; `output` holds it.
macro(run)
    execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(NOT status EQUAL 0)
        string(REPLACE ";" " " line "${ARGN}")
        message(FATAL_ERROR "${line}\nfailed (${status}):\n${output}")
    endif()
endmacro()
