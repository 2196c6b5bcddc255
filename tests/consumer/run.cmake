# run(COMMAND ...): puts what the command prints into `output`; if it fails, so does the test, printing that.
macro(run)
    execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(NOT status EQUAL 0)
        string(REPLACE ";" " " line "${ARGN}")
        message(FATAL_ERROR "${line}\nfailed (${status}):\n${output}")
    endif()
endmacro()
