find_package(Threads REQUIRED)

# gmis_add_example(NAME sources…): a program that is run as a test, too.
function(gmis_add_example name)
  add_executable(${name} ${ARGN})
  target_link_libraries(${name} PRIVATE gmis::gmis gmis_warnings Threads::Threads)
  if(GMIS_BUILD_TESTS)
    add_test(NAME example_${name} COMMAND ${name})
  endif()
endfunction()

gmis_add_example(render_a_scene render_a_scene.cpp)
gmis_add_example(bring_your_own bring_your_own/main.cpp)
