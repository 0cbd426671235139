# The libraries behind gmis-render, which the tests link too: scene files in, images in and out.
# gmis_scene_reader reads them all, gmis_pbrt_reader all but glTF.
# Included from examples/ and from tests/program/, whichever comes first. Sets
# GMIS_RENDER_CAN_BE_BUILT.

set(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL ON)
find_package(OpenEXR CONFIG QUIET)
find_package(PNG QUIET)
find_package(OpenImageDenoise CONFIG QUIET)
find_package(TBB CONFIG QUIET)
find_package(ZLIB QUIET)
find_path(GMIS_STB_FOLDER stb/stb_image.h)
if(GMIS_STB_FOLDER AND NOT TARGET gmis_stb)
  add_library(gmis_stb INTERFACE)
  target_include_directories(gmis_stb SYSTEM INTERFACE ${GMIS_STB_FOLDER})
endif()
if(GMIS_FETCH_DEPENDENCIES)
  gmis_find_dependency(CLI11 CLI11::CLI11 https://github.com/CLIUtils/CLI11.git v2.4.2)
  gmis_find_dependency(nlohmann_json nlohmann_json::nlohmann_json https://github.com/nlohmann/json.git v3.11.3)
else()
  find_package(CLI11 CONFIG QUIET)
  find_package(nlohmann_json CONFIG QUIET)
endif()
find_path(GMIS_DRACO_FOLDER draco/compression/decode.h)
find_library(GMIS_DRACO_LIBRARY draco)
if(GMIS_DRACO_FOLDER AND GMIS_DRACO_LIBRARY AND NOT TARGET gmis_draco)
  add_library(gmis_draco INTERFACE)
  target_include_directories(gmis_draco SYSTEM INTERFACE ${GMIS_DRACO_FOLDER})
  target_link_libraries(gmis_draco INTERFACE ${GMIS_DRACO_LIBRARY})
endif()
find_path(GMIS_MESHOPT_FOLDER meshoptimizer.h)
find_library(GMIS_MESHOPT_LIBRARY meshoptimizer)
if(GMIS_MESHOPT_FOLDER AND GMIS_MESHOPT_LIBRARY AND NOT TARGET gmis_meshopt)
  add_library(gmis_meshopt INTERFACE)
  target_include_directories(gmis_meshopt SYSTEM INTERFACE ${GMIS_MESHOPT_FOLDER})
  target_link_libraries(gmis_meshopt INTERFACE ${GMIS_MESHOPT_LIBRARY})
endif()
unset(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL)

set(GMIS_RENDER_CAN_BE_BUILT OFF)
if(TARGET CLI11::CLI11 AND TARGET nlohmann_json::nlohmann_json)
  set(GMIS_RENDER_CAN_BE_BUILT ON)
endif()

# gmis_optional_part(TARGET-OF-THE-LIBRARY MACRO "what is missing without it")
function(gmis_optional_part library macro consequence)
  if(TARGET ${library})
    target_compile_definitions(gmis_pbrt_reader PUBLIC ${macro}=1)
    target_link_libraries(gmis_pbrt_reader PUBLIC ${library})
  else()
    target_compile_definitions(gmis_pbrt_reader PUBLIC ${macro}=0)
    message(STATUS "gmis: ${library} not found: ${consequence}")
  endif()
endfunction()

if(TARGET gmis_scene_reader)
  return()
endif()

set(support ${CMAKE_CURRENT_LIST_DIR}/support)
add_library(gmis_pbrt_reader STATIC
  ${support}/image/exr.cpp
  ${support}/image/image.cpp
  ${support}/image/pfm.cpp
  ${support}/image/png.cpp
  ${support}/image/texture_image.cpp
  ${support}/pbrt/color_spaces.cpp
  ${support}/pbrt/directives.cpp
  ${support}/pbrt/lexer.cpp
  ${support}/pbrt/lights.cpp
  ${support}/pbrt/materials.cpp
  ${support}/pbrt/parameters.cpp
  ${support}/pbrt/parser.cpp
  ${support}/pbrt/reader.cpp
  ${support}/pbrt/shapes.cpp
  ${support}/pbrt/smooth_shapes.cpp
  ${support}/pbrt/spectra.cpp
  ${support}/pbrt/textures.cpp
  ${support}/pbrt/transform.cpp
  ${support}/load_budget.cpp
  ${support}/ply_mesh.cpp
  ${support}/read_file.cpp
  ${support}/scene_description.cpp
  ${support}/sky.cpp
  ${support}/whole_file.cpp)
target_include_directories(gmis_pbrt_reader PUBLIC ${CMAKE_CURRENT_LIST_DIR})
target_link_libraries(gmis_pbrt_reader PUBLIC gmis::gmis PRIVATE gmis_warnings)
target_compile_options(gmis_pbrt_reader PRIVATE $<$<CONFIG:Debug>:-O0>)  # much to compile, little to run
# Parsed once for all that is behind the programs.
target_precompile_headers(gmis_pbrt_reader PRIVATE
  <algorithm> <array> <charconv> <cmath> <cstdint> <filesystem> <fstream> <functional> <map> <memory> <optional> <sstream>
  <string> <string_view> <utility> <variant> <vector>
  <glm/common.hpp> <glm/geometric.hpp> <glm/mat3x3.hpp> <glm/mat4x4.hpp> <glm/matrix.hpp> <glm/vec2.hpp> <glm/vec3.hpp>)
gmis_optional_part(OpenEXR::OpenEXR GMIS_HAS_OPENEXR "gmis-render reads and writes no .exr")
gmis_optional_part(PNG::PNG GMIS_HAS_PNG "gmis-render writes no .png")
gmis_optional_part(OpenImageDenoise GMIS_HAS_OIDN "gmis-render has no --denoise")
gmis_optional_part(gmis_stb GMIS_HAS_STB "gmis-render reads no textures from .png, .tga and .jpg")
gmis_optional_part(nlohmann_json::nlohmann_json GMIS_HAS_JSON "gmis-render reads no glTF")
gmis_optional_part(gmis_draco GMIS_HAS_DRACO "gmis-render reads no glTF that Draco packs")
gmis_optional_part(gmis_meshopt GMIS_HAS_MESHOPT "gmis-render reads no glTF that meshoptimizer packs")

add_library(gmis_scene_reader STATIC ${support}/gltf/reader.cpp ${support}/read_scene.cpp)
target_link_libraries(gmis_scene_reader PUBLIC gmis_pbrt_reader PRIVATE gmis_warnings)
target_compile_options(gmis_scene_reader PRIVATE $<$<CONFIG:Debug>:-O0>)
target_precompile_headers(gmis_scene_reader REUSE_FROM gmis_pbrt_reader)
if(TARGET nlohmann_json::nlohmann_json)
  target_sources(gmis_scene_reader PRIVATE ${support}/gltf/document.cpp ${support}/gltf/materials.cpp
                                           ${support}/gltf/nodes.cpp ${support}/gltf/primitive.cpp)
endif()
# Several files compiled as one: in half of the time.
set_target_properties(gmis_pbrt_reader gmis_scene_reader PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
gmis_optional_part(ZLIB::ZLIB GMIS_HAS_ZLIB "gmis-render reads no plymesh from .ply.gz")
gmis_optional_part(TBB::tbb GMIS_HAS_TBB "gmis-render runs on one thread")
