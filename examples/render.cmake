include(${CMAKE_CURRENT_LIST_DIR}/scene_reader.cmake)
if(NOT GMIS_RENDER_CAN_BE_BUILT)
  message(STATUS "gmis: gmis-render and gmis-demo need CLI11 and nlohmann_json: they are not built")
  return()
endif()

# Where the time of a rendering goes. Programs link these objects before all others: of an inline
# function that is compiled in many files the linker keeps the first, which is to be an optimised
# one (tests/linkage/engines_first.py).
add_library(gmis_render_engines OBJECT
  support/build_scene.cpp
  support/engines/both_sides.cpp
  support/engines/camera_side.cpp
  support/engines/engines.cpp
  support/engines/pilot.cpp
  support/engines/split_trees.cpp
  support/executor.cpp
  support/progressive_render.cpp)
target_link_libraries(gmis_render_engines PUBLIC gmis_pbrt_reader PRIVATE gmis_warnings)
target_compile_options(gmis_render_engines PRIVATE ${gmis_full_options})

# From a scene to a picture.
add_library(gmis_render_session STATIC
  support/choices.cpp
  support/integrator_names.cpp
  support/scene_files.cpp
  support/session.cpp)
target_link_libraries(gmis_render_session PUBLIC gmis_pbrt_reader PRIVATE gmis_render_engines gmis_warnings)
target_compile_definitions(gmis_render_session PRIVATE GMIS_SCENE_FOLDER="${CMAKE_CURRENT_SOURCE_DIR}/scenes")

# What gmis-render adds; the demo does without it.
add_library(gmis_render_program STATIC
  support/denoise.cpp
  support/first_hit_layers.cpp
  support/hidden_sky.cpp
  support/load_scene.cpp
  support/manual.cpp
  support/options.cpp
  support/output.cpp
  support/plan_text.cpp
  support/progress_bar.cpp
  support/render.cpp
  support/replay.cpp
  support/replay_text.cpp
  support/statistics.cpp
  support/technique_sheet.cpp
  support/tev.cpp)
target_link_libraries(gmis_render_program PUBLIC gmis_render_session gmis_scene_reader PRIVATE gmis_warnings CLI11::CLI11
                                                                            nlohmann_json::nlohmann_json)
target_compile_definitions(gmis_render_program PRIVATE GMIS_VERSION="${PROJECT_VERSION}")

# Traces one path.
set_source_files_properties(support/replay.cpp PROPERTIES COMPILE_OPTIONS "${gmis_no_optimization}"
                                                          SKIP_PRECOMPILE_HEADERS ON)

add_library(gmis_report STATIC
  support/report/comparison.cpp
  support/report/false_colour.cpp
  support/report/figures.cpp
  support/report/html_report.cpp
  support/report/metrics.cpp
  support/report/plot.cpp
  support/report/tables.cpp)
target_link_libraries(gmis_report PUBLIC gmis_render_session PRIVATE gmis_warnings nlohmann_json::nlohmann_json)
target_compile_definitions(gmis_report PRIVATE GMIS_VERSION="${PROJECT_VERSION}")

# Much to compile, little to run.
foreach(library gmis_render_session gmis_render_program gmis_report)
  target_compile_options(${library} PRIVATE $<$<CONFIG:Debug>:-O0>)
  target_precompile_headers(${library} REUSE_FROM gmis_pbrt_reader)
endforeach()

# The program but for its main function.
add_library(gmis_render_main OBJECT gmis_render.cpp)
target_link_libraries(gmis_render_main PUBLIC gmis_render_program PRIVATE gmis_warnings)
target_compile_definitions(gmis_render_main PRIVATE GMIS_VERSION="${PROJECT_VERSION}")

add_executable(gmis-render gmis_render_main.cpp)
add_executable(gmis-compare gmis_compare.cpp)
add_executable(gmis-demo gmis_demo.cpp)
target_link_libraries(gmis-render PRIVATE gmis_render_engines gmis_render_main gmis_warnings)
foreach(program compare demo)
  target_link_libraries(gmis-${program} PRIVATE gmis_render_engines gmis_report gmis_warnings)
endforeach()

# The same over MPI.
find_package(MPI QUIET COMPONENTS CXX)
if(MPI_CXX_FOUND)
  add_executable(gmis-render-mpi gmis_render_mpi.cpp)
  target_link_libraries(gmis-render-mpi PRIVATE gmis_render_engines gmis_render_main MPI::MPI_CXX gmis_warnings)
  target_compile_definitions(gmis-render-mpi PRIVATE OMPI_SKIP_MPICXX)
else()
  message(STATUS "gmis: no MPI here: gmis-render-mpi is not built")
endif()
target_link_libraries(gmis-compare PRIVATE gmis_render_program CLI11::CLI11)
target_compile_definitions(gmis-compare PRIVATE GMIS_VERSION="${PROJECT_VERSION}")

# cmake --install BUILD --component gmis-render
if(GMIS_INSTALL)
  include(GNUInstallDirs)
  install(TARGETS gmis-render RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT gmis-render EXCLUDE_FROM_ALL)
  install(DIRECTORY scenes/ DESTINATION ${CMAKE_INSTALL_DATADIR}/gmis/scenes COMPONENT gmis-render EXCLUDE_FROM_ALL)
  # The program prints them itself.
  foreach(printed IN ITEMS
    "--man|${CMAKE_INSTALL_MANDIR}/man1|gmis-render.1"
    "--completion bash|${CMAKE_INSTALL_DATADIR}/bash-completion/completions|gmis-render"
    "--completion zsh|${CMAKE_INSTALL_DATADIR}/zsh/site-functions|_gmis-render"
    "--completion fish|${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d|gmis-render.fish")
    string(REPLACE "|" ";" printed "${printed}")
    list(GET printed 0 arguments)
    list(GET printed 1 folder)
    list(GET printed 2 file)
    install(CODE "
      set(folder \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${folder}\")
      file(MAKE_DIRECTORY \"\${folder}\")
      execute_process(COMMAND \"$<TARGET_FILE:gmis-render>\" ${arguments}
        OUTPUT_FILE \"\${folder}/${file}\" COMMAND_ERROR_IS_FATAL ANY)
      message(STATUS \"Installing: \${folder}/${file}\")
      " COMPONENT gmis-render EXCLUDE_FROM_ALL)
  endforeach()
endif()
