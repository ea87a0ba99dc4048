# Builds core and fitting alone, installs them into an empty prefix, then builds and runs a foreign project against that.
function(step)
    execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE out ERROR_VARIABLE out)
    if(NOT code EQUAL 0)
        message(FATAL_ERROR "${ARGN}\n${out}")
    endif()
endfunction()
file(REMOVE_RECURSE ${WORK}/prefix ${WORK}/consumer)
# With the options of the build under test, so that a compiler cache has the objects.
step(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK} -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release -DCMMLIVE_WERROR=${WERROR}
    -DCMMLIVE_FITTING_ONLY=ON -DCMAKE_INSTALL_PREFIX=${WORK}/prefix)
step(${CMAKE_COMMAND} --build ${WORK})
step(${CMAKE_COMMAND} --install ${WORK})
step(${CMAKE_COMMAND} -S ${SOURCE}/tests/install/consumer -B ${WORK}/consumer -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_PREFIX_PATH=${WORK}/prefix)
step(${CMAKE_COMMAND} --build ${WORK}/consumer)
step(${WORK}/consumer/consumer)
