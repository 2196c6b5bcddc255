# Installs BUILD below WORK, then configures, builds and runs PROJECT against what was installed.
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --config ${CONFIG} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${PROJECT} -B ${WORK}/build -G ${GENERATOR}
    -DCMAKE_CXX_COMPILER=${CXX_COMPILER} -DCMAKE_CXX_FLAGS=${CXX_FLAGS}
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH=${WORK}/prefix)
run(${CMAKE_COMMAND} --build ${WORK}/build --config Release)

find_program(renderer renderer PATHS ${WORK}/build ${WORK}/build/Release NO_DEFAULT_PATH REQUIRED)
run(${renderer})
# (w / 4) phi (1 - exp(-8)) / (mu + mu0) with phi = 0.75 / 0.75^1.5 at cos Theta = 0.5
if(NOT output STREQUAL "R = 0.259720 + 0.250000\n")
    message(FATAL_ERROR "R = 0.259720 + 0.250000 was to be printed, got ${output}")
endif()
