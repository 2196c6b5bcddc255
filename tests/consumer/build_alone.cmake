# Builds PROJECT in WORK with Stratus as a subfolder, with find_package made fatal.
include(${CMAKE_CURRENT_LIST_DIR}/use.cmake)

# Check that find_package is indeed fatal: the tests call it.
execute_process(COMMAND ${CMAKE_COMMAND} -S ${PROJECT} -B ${WORK}/with_tests -G ${GENERATOR}
                        -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_CXX_COMPILER=${CXX_COMPILER}
                        ${ARGUMENTS} -DSTRATUS_BUILD_TESTS=ON
                RESULT_VARIABLE status OUTPUT_QUIET ERROR_VARIABLE output)
if(status EQUAL 0 OR NOT output MATCHES "find_package\\(GTest\\) was called")
    message(FATAL_ERROR "find_package was not refused:\n${output}")
endif()
