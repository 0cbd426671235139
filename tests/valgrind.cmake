# Quick tests once more under valgrind, which sees reads of memory that was never written:
# `./run valgrind`, and among the slow tests. Tests whose oracle needs all digits of long double are
# left out: valgrind computes it in 64 bits.
find_program(GMIS_VALGRIND valgrind)
add_custom_target(valgrind_tests)
if(NOT GMIS_VALGRIND)
  message(STATUS "gmis: no valgrind here: no tests under it")
endif()

# gmis_add_valgrind_test(PROGRAM arguments…)
function(gmis_add_valgrind_test program)
  if(NOT GMIS_VALGRIND OR NOT TARGET ${program})
    return()
  endif()
  add_dependencies(valgrind_tests ${program})
  set(name valgrind_${program})
  add_test(NAME ${name} COMMAND ${GMIS_VALGRIND} -q --error-exitcode=99 --leak-check=full --errors-for-leak-kinds=definite
                                $<TARGET_FILE:${program}> ${ARGN})
  set_tests_properties(${name} PROPERTIES LABELS "slow;valgrind;no-sanitizer" TIMEOUT 600)
endfunction()

gmis_add_valgrind_test(test_hostile_mis "hostile: point masses,hostile: disjoint supports*,hostile: a sample on*")
gmis_add_valgrind_test(test_hostile_accumulators)
gmis_add_valgrind_test(test_hostile_degenerate "hostile: a link*,hostile: triangles*,hostile: what is not finite*")
gmis_add_valgrind_test(test_scene_builder "what is no scene*,an empty scene*,triangles without area*,hits carry*")
gmis_add_valgrind_test(test_core_film)
gmis_add_valgrind_test(test_transport_grid "the grid is exact*,a grid can be built again*")
if(NOT GMIS_HAS_FUZZER)  # a fuzzer's program brings an allocator of its own
  set(corpus ${CMAKE_CURRENT_SOURCE_DIR}/fuzz/corpus)
  gmis_add_valgrind_test(fuzz_bvh ${corpus}/bvh)
  gmis_add_valgrind_test(fuzz_reader ${corpus}/reader ${PROJECT_SOURCE_DIR}/examples/scenes)
endif()
