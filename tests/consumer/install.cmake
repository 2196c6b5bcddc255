# Installs BUILD and moves the copy to PREFIX: installed files must not contain their first path.
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${PREFIX} ${PREFIX}.first)
run(${CMAKE_COMMAND} --install ${BUILD} --config ${CONFIG} --prefix ${PREFIX}.first)
file(RENAME ${PREFIX}.first ${PREFIX})
