# run(COMMAND ...): runs a command and sets `output` to what it printed; if it fails, so does the test, with the output.
macro(run)
    execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(NOT status EQUAL 0)
        string(REPLACE ";" " " line "${ARGN}")
        message(FATAL_ERROR "${line}\nfailed (${status}):\n${output}")
    endif()
endmacro()
