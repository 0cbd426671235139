# gmis_add_negative_compile_test(NAME SOURCE EXPECTED): a CTest entry that compiles SOURCE twice.
# With -DGMIS_EXPECT_OK the fault is absent and it must compile; without, it must fail with a
# message that matches the regular expression EXPECTED. LINES n: and the compiler says no more than
# n lines. FAULT name: the fault is chosen by -DGMIS_FAULT_name, one of several in SOURCE; that
# SOURCE compiles without any is an entry of its own, with EXPECTED empty.
function(gmis_add_negative_compile_test name source expected)
  cmake_parse_arguments(PARSE_ARGV 3 arg "" "LINES;FAULT" "")
  add_test(
    NAME ${name}
    COMMAND
      ${CMAKE_COMMAND} -E env LC_ALL=C ${CMAKE_COMMAND} "-DCOMPILER=${CMAKE_CXX_COMPILER}" "-DSTANDARD=${CMAKE_CXX20_STANDARD_COMPILE_OPTION}"
      "-DINCLUDES=${PROJECT_SOURCE_DIR}/include;${PROJECT_SOURCE_DIR}/tests"
      "-DSYSTEM_INCLUDES=$<TARGET_PROPERTY:glm::glm,INTERFACE_INCLUDE_DIRECTORIES>"
      "-DSOURCE=${CMAKE_CURRENT_SOURCE_DIR}/${source}" "-DEXPECTED=${expected}" "-DLINES=${arg_LINES}"
      "-DFAULT=${arg_FAULT}" -P
      ${PROJECT_SOURCE_DIR}/tests/negative_compile/compile_twice.cmake)
  gmis_part_needs()
  gmis_label_test(${name})
endfunction()
