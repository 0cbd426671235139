#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "support/load_budget.hpp"
#include "support/scene_description.hpp"

namespace gmis::tools::gltf {

using Json = nlohmann::json;

/// A glTF file as it was parsed, with the data that it refers to. Whatever is asked for is checked:
/// the functions throw `InputError` for what is not there, is of the wrong type, or goes beyond the
/// end of its data. Data come from inside the folder of the file alone, and count against the
/// budget before they are read.
class Document {
 public:
  /// Reads the file. `used` hears of every other file that is read.
  Document(const std::filesystem::path& file, LoadBudget& budget,
           std::function<void(const std::filesystem::path&)> used);
  /// The same from the bytes of a file; `file` is its name.
  Document(std::string bytes, const std::filesystem::path& file, LoadBudget& budget,
           std::function<void(const std::filesystem::path&)> used);

  [[nodiscard]] const Json& root() const { return json_; }
  [[nodiscard]] const SourcePosition& where() const { return where_; }
  [[nodiscard]] LoadBudget& budget() const { return budget_; }
  [[nodiscard]] InputError error(const std::string& message) const { return {where_, message}; }

  /// A member of an object; null where there is none.
  [[nodiscard]] static const Json& member(const Json& object, const char* name);
  /// An extension of an object; null where there is none.
  [[nodiscard]] static const Json& extension(const Json& object, const char* name);
  [[nodiscard]] double number(const Json& object, const char* name, double otherwise) const;
  [[nodiscard]] std::string text(const Json& object, const char* name, const std::string& otherwise = "") const;
  /// The numbers of a list, of this length; `otherwise` where there is none.
  [[nodiscard]] std::vector<double> numbers(const Json& object, const char* name, std::vector<double> otherwise) const;
  /// A whole number ≥ 0; nothing where there is none. Errors name `owner`, which has it.
  [[nodiscard]] std::optional<std::size_t> index(const Json& object, const char* name,
                                                 const std::string& owner = "") const;
  /// An entry of one of the lists of the file, such as "meshes". Errors name `owner`, which asks
  /// for it.
  [[nodiscard]] const Json& entry(const char* list, std::size_t number, const std::string& owner = "") const;
  [[nodiscard]] std::size_t count(const char* list) const;
  /// "mesh 3", or "mesh "chair"" where it has a name.
  [[nodiscard]] std::string named(const char* kind, const Json& object, std::size_t number) const;

  /// The numbers of an accessor in a row, `components` for each element; normalised integers from
  /// −1 or 0 to 1.
  [[nodiscard]] std::vector<double> accessor(std::size_t number, std::size_t components,
                                             const std::string& owner = "") const;
  [[nodiscard]] std::size_t components_of(std::size_t accessor, const std::string& owner = "") const;
  /// The bytes of a view, unpacked where EXT_meshopt_compression packs them.
  [[nodiscard]] std::string_view view(std::size_t number, const std::string& owner = "") const;
  /// The bytes of an image, as a file of images has them, and its name.
  struct ImageFile {
    std::string name, bytes;
  };
  [[nodiscard]] ImageFile image(std::size_t number) const;

 private:
  void parse(std::string bytes);
  [[nodiscard]] const std::string& buffer(std::size_t number, const std::string& owner) const;
  /// The content of a uri: its own data, or a file.
  [[nodiscard]] std::string content(const std::string& uri, const std::string& what) const;
  [[nodiscard]] std::string_view part(std::size_t buffer, double offset, double length, const std::string& what) const;
  [[nodiscard]] const std::string& unpacked_view(std::size_t number, const Json& packed) const;
  void read_values(std::vector<double>& result, const Json& accessor, std::string_view data, std::size_t stride,
                   std::size_t offset, std::size_t count, std::size_t components, const std::string& what) const;
  void replace_sparse(std::vector<double>& result, const Json& accessor, std::size_t components,
                      const std::string& what) const;

  std::filesystem::path file_;
  SourcePosition where_;
  LoadBudget& budget_;
  std::function<void(const std::filesystem::path&)> used_;
  Json json_;
  std::optional<std::string> chunk_;  ///< the binary part of a .glb file
  mutable std::map<std::size_t, std::string> buffers_, unpacked_;
};

}  // namespace gmis::tools::gltf
