find_package(Threads REQUIRED)

# gmis_add_example(NAME sources…): a program that is run as a test, too. It renders for a moment
# only.
function(gmis_add_example name)
  add_executable(${name} ${ARGN})
  target_compile_options(${name} PRIVATE ${gmis_no_optimization})
  target_link_libraries(${name} PRIVATE gmis::gmis gmis_warnings Threads::Threads)
  if(GMIS_BUILD_TESTS)
    add_test(NAME example_${name} COMMAND ${name})
  endif()
endfunction()

gmis_add_example(render_a_scene render_a_scene.cpp)
gmis_add_example(first_render first_render.cpp)
gmis_add_example(bring_your_own bring_your_own/main.cpp)
gmis_add_example(bring_your_own_check bring_your_own/check.cpp)
# The same program with its engines in one file, over the library's compiled parts.
gmis_add_example(bring_your_own_declared ${PROJECT_SOURCE_DIR}/bench/compile/engines_declared.cpp bring_your_own/engines.cpp)
target_include_directories(bring_your_own_declared PRIVATE ${CMAKE_CURRENT_SOURCE_DIR} bring_your_own)
target_link_libraries(bring_your_own_declared PRIVATE gmis::compiled)
gmis_add_example(many_lights many_lights/main.cpp)

# Embree, version 3 as Debian 12 has it, or 4.
foreach(version 4 3)
  if(NOT TARGET embree)
    find_package(embree ${version} QUIET GLOBAL)
  endif()
endforeach()
if(TARGET embree)
  gmis_add_example(render_with_embree embree/main.cpp)
  target_link_libraries(render_with_embree PRIVATE embree)
else()
  message(STATUS "gmis: no Embree here (Debian: libembree-dev): examples/embree is not built")
endif()
gmis_add_example(guided_directions guided_directions/main.cpp)
target_include_directories(guided_directions PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
