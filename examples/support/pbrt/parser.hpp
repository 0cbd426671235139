#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "support/pbrt/elements.hpp"

namespace gmis::tools::pbrt {

/// Walks through the directives of a scene and fills in a `SceneDescription`.
class Parser {
 public:
  Parser(std::filesystem::path folder, SceneDescription& scene, Diagnostics& diagnostics, LoadBudget& budget);

  /// Reads all of `text`, with the files it includes.
  void parse_text(std::string text, const std::string& name);
  void parse_file(const std::filesystem::path& file);
  /// Checks what can be known at the end only.
  void finish(const std::string& name);

 private:
  /// A medium by its name, and what it absorbs per scene unit; without a name there is none.
  struct Medium {
    std::string name;
    Rgb sigma{0};
  };
  struct GraphicsState {
    Transform transform{1};
    Transform end_transform{1};                         ///< the same at the end of a motion
    bool is_start_active = true, is_end_active = true;  ///< which of the two directives change
    bool reverse_orientation = false;
    glm::dmat3 to_srgb{1};  ///< of ColorSpace
    std::size_t material = 0;
    bool is_interface = false;  ///< the material is the boundary of a medium alone, and cannot be seen
    Medium inside, outside;     ///< of the shapes that follow
    std::optional<AreaLight> area_light;
    /// Parameters of the directive Attribute by target; shared with the blocks around this one.
    std::map<std::string, std::shared_ptr<const std::vector<Parameter>>> defaults;
  };
  struct Saved {
    GraphicsState state;
    std::string closed_by;
    SourcePosition where;
  };
  using Handler = void (Parser::*)();
  struct Directive {
    Handler handler;
    enum class Place { anywhere, before_world, in_world } place = Place::anywhere;
    bool is_kept = false;  ///< what it makes stays to the end
  };
  static const std::map<std::string, Directive>& directives();

  // Reading.
  void parse_directive(const Token& word);
  void skip_unknown(const Token& word);
  void skip_to_directive();
  [[nodiscard]] std::string expect_string(const char* what);
  [[nodiscard]] std::vector<double> expect_numbers(std::size_t count);
  [[nodiscard]] Parameters parse_parameters(const std::string& kind, const char* defaults_of = nullptr);
  [[nodiscard]] Parameter parse_parameter();
  void parse_value(Parameter& parameter);
  void parse_nested(Lexer& lexer);
  /// Throws when the file does not begin with a directive. The message quotes nothing of the file:
  /// a file that is no scene may be confidential.
  static void require_scene(const Lexer& lexer);
  [[nodiscard]] std::filesystem::path resolve(const std::string& file) const;
  /// `resolve`, for a file that will be read.
  [[nodiscard]] std::filesystem::path find(const std::string& name);
  [[nodiscard]] std::string named_directive(const std::string& kind) const;
  void ignored_with_note();

  // State.
  void concat(const Transform& m);
  /// Applies `change` to the transforms that ActiveTransform chooses. Throws where space leaves the
  /// range of numbers.
  template <class Change>
  void change_transforms(const Change& change);
  /// Reports a shape, a light or a camera that moves.
  void require_rest();
  void save(const std::string& closed_by);
  void restore(const std::string& closed_by);
  /// The current material is one that light passes through unchanged: the boundary of a medium.
  [[nodiscard]] bool is_unseen_interface();
  /// The media that MediumInterface names, where they matter to this shape.
  [[nodiscard]] std::optional<AbsorptionDescription> media_of(const ShapeDescription& shape);
  void require_closed_media();
  void place_shape(ShapeDescription shape, const Transform& world_from_shape, const SourcePosition& where);
  void copy_instances();
  void count_material();

  [[nodiscard]] MaterialDescription any_material(const std::string& kind, Parameters& parameters);

  // One for each directive.
  void accelerator() { ignored_with_note(); }
  void active_transform();
  void attribute();
  void attribute_begin() { save("AttributeEnd"); }
  void attribute_end() { restore("AttributeEnd"); }
  void area_light_source();
  void camera();
  void color_space();
  void concat_transform();
  void coordinate_system();
  void coord_sys_transform();
  void film();
  void identity();
  void import();
  void include();
  void light_source();
  void look_at_directive();
  void make_named_material();
  void make_named_medium();
  void material();
  void medium_interface();
  void named_material();
  void object_begin();
  void object_end();
  void object_instance();
  void option();
  void pixel_filter();
  void read_crop(Parameters& parameters);
  void reverse_orientation() { state_.reverse_orientation = !state_.reverse_orientation; }
  void rotate();
  void scale();
  void shape();
  void texture();
  void transform();
  void transform_times();
  void translate();
  void world_begin();

  std::filesystem::path folder_;
  SceneDescription& scene_;
  Diagnostics& diagnostics_;
  LoadBudget& budget_;
  Lexer* lexer_ = nullptr;
  int include_depth_ = 0;
  Token directive_;
  bool in_world_ = false;
  GraphicsState state_;
  std::vector<Saved> saved_;
  Textures textures_;
  Files files_;
  std::map<std::string, std::array<Transform, 2>> coordinate_systems_;  ///< at the start and at the end
  std::map<std::string, std::size_t> named_materials_;
  std::set<std::string> interfaces_;                 ///< named materials that cannot be seen
  std::map<std::string, std::optional<Rgb>> media_;  ///< what they absorb; nothing where a medium does more than that
  std::set<std::string> enclosed_media_;             ///< inside of a dielectric
  std::map<std::string, SourcePosition> outside_media_;  ///< outside of some shape
  std::map<std::string, std::vector<ShapeDescription>> objects_;
  /// An ObjectInstance. They are copied at the end, when it is known that there is room for all of
  /// them.
  struct Instance {
    const std::vector<ShapeDescription>* shapes;
    Transform world_from_object;
    SourcePosition where;
  };
  std::vector<Instance> instances_;
  std::vector<double> mix_sizes_;  ///< by number of the material: how many there are in its tree of mixtures
  std::string open_object_;
  SourcePosition open_object_where_;
  double film_exposure_ = 1, camera_exposure_ = 1;  ///< factors on all light
  glm::dmat3 white_balance_{1};                     ///< of the film, on the colours of all light
};

}  // namespace gmis::tools::pbrt
