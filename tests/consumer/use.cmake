# Configures and builds PROJECT in WORK with the settings in ARGUMENTS, and runs its PROGRAMS, each of which must print the
# corresponding line of PRINTED.
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} -S ${PROJECT} -B ${WORK} -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_CXX_COMPILER=${CXX_COMPILER} ${ARGUMENTS})
run(${CMAKE_COMMAND} --build ${WORK} --config Release)
foreach(program expected IN ZIP_LISTS PROGRAMS PRINTED)
    find_program(${program} ${program} PATHS ${WORK} ${WORK}/Release NO_DEFAULT_PATH REQUIRED)
    run(${${program}} WORKING_DIRECTORY ${WORK})
    if(NOT output STREQUAL "${expected}\n")
        message(FATAL_ERROR "${program}: must print '${expected}', got ${output}")
    endif()
endforeach()
