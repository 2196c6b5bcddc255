# Configures and builds SOURCE below WORK without the baker and the tests, where find_package is fatal.
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

set(configure ${CMAKE_COMMAND} -S ${SOURCE} -G ${GENERATOR} -DSTRATUS_BUILD_BAKER=OFF
    -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_CXX_COMPILER=${CXX_COMPILER}
    -DCMAKE_PROJECT_TOP_LEVEL_INCLUDES=${CMAKE_CURRENT_LIST_DIR}/refuse_packages.cmake)

file(REMOVE_RECURSE ${WORK})
run(${configure} -B ${WORK}/build -DSTRATUS_BUILD_TESTS=OFF)
run(${CMAKE_COMMAND} --build ${WORK}/build)

# The trap must be seen to close: the tests do look for a package.
execute_process(COMMAND ${configure} -B ${WORK}/trapped -DSTRATUS_BUILD_TESTS=ON
                RESULT_VARIABLE status OUTPUT_QUIET ERROR_VARIABLE output)
if(status EQUAL 0 OR NOT output MATCHES "find_package\\(GTest\\) was called")
    message(FATAL_ERROR "find_package was not refused:\n${output}")
endif()
