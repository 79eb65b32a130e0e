// SPDX-License-Identifier: MIT
//
// Files of Compact-3DGS that were changed to do harm, made of the small model: each is refused with
// one sentence, within the limits of time and memory.
#include <cstring>
#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "io/support/limits.h"
#include "io/support/zip_archive.h"
#include "io/tensor/npy.h"
#include "support/corpus.h"
#include "support/error_of.h"
#include "support/scene_files.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::AnyOf;
using testing::HasSubstr;
using testing::StartsWith;

std::filesystem::path small_file(const std::string& ending) {
  return committed_corpus() / ("valid/compact_small" + ending);
}

// The sentence about a changed copy of the model; "" if it was read.
class ChangedModel {
 public:
  using Change = std::function<void(ZipEntries&)>;

  std::string npz(const Change& change) const { return archive(".npz", "a.npz", "a.npz", change); }
  std::string processed(const Change& change) const {
    return archive("_pp.npz", "a.npz", "a.npz", change);
  }
  std::string pth(const Change& change) const {
    std::filesystem::copy_file(small_file(".ply"), folder_ / "a.ply",
                               std::filesystem::copy_options::overwrite_existing);
    return archive(".pth", "a.pth", "a.ply", change);
  }

 private:
  std::string archive(const char* ending, const char* name, const char* opened,
                      const Change& change) const {
    ZipEntries entries = zip_entries(small_file(ending));
    change(entries);
    write_zip(folder_ / name, entries, true);
    std::string sentence;
    expect_within_limits([&]() -> std::size_t {
      try {
        return bytes_of(read_scene(folder_ / opened).cloud);
      } catch (const Error& error) {
        sentence = without_folder(error.what(), folder_.path());
        EXPECT_EQ(error.kind(), ErrorKind::input);
        EXPECT_EQ(sentence.find('\n'), std::string::npos);
        return 0;
      }
    });
    return sentence;
  }

  TemporaryFolder folder_;
};

// An array with these values behind NumPy's header.
std::string npy(const std::string& type, const std::string& shape, const std::string& values) {
  return npy_header(type, shape) + values;
}

void replace_entry(ZipEntries& entries, const std::string& name, const std::string& content) {
  entry(entries, name) = content;
}

void erase_entry(ZipEntries& entries, const std::string& name) {
  std::erase_if(entries, [&](const auto& item) { return item.first == name; });
}

TEST(CompactHostile, unchanged_copies_are_read) {
  const ChangedModel model;
  const auto nothing = [](ZipEntries&) {};
  EXPECT_EQ(model.npz(nothing), "");
  EXPECT_EQ(model.processed(nothing), "");
  EXPECT_EQ(model.pth(nothing), "");
}

TEST(CompactHostile, counts_that_disagree_are_refused) {
  const ChangedModel model;
  const auto with = [&](const std::string& name, const std::string& content) {
    return model.npz([&](ZipEntries& e) { replace_entry(e, name, content); });
  };
  EXPECT_EQ(with("xyz.npy", npy("<f2", "(149, 3)", std::string(149 * 6, '\0'))),
            "a.npz: opacity: has 150 values instead of 149");
  EXPECT_EQ(with("xyz.npy", npy("<f2", "(450,)", std::string(900, '\0'))),
            "a.npz: xyz: has not the shape (N, 3)");
  EXPECT_EQ(with("xyz.npy", npy("<f4", "(150, 3)", std::string(1800, '\0'))),
            "a.npz: xyz: has values of another type than <f2");
  EXPECT_EQ(with("xyz.npy", npy("<f2", "(4611686018427387904, 3)", std::string(900, '\0'))),
            "a.npz: xyz: its shape does not fit its 900 bytes of values");
  EXPECT_EQ(with("scale.npy", npy("|u1", "(674,)", std::string(674, '\0'))),
            "a.npz: scale: has 674 bytes instead of 675 for 150 Gaussians");
  EXPECT_EQ(with("mlp.npy", npy("<f2", "(8190,)", std::string(16380, '\0'))),
            "a.npz: its network has 8190 weights, but networks of Compact-3DGS have 8192");
  EXPECT_EQ(with("hash.npy", npy("<f2", "(2050,)", std::string(4100, '\0'))),
            "a.npz: its hash grid has 2050 values, which fit no grid of Compact-3DGS");
  EXPECT_EQ(with("hash.npy", npy("<f2", "(0,)", "")),
            "a.npz: its hash grid has 0 values, which fit no grid of Compact-3DGS");
  const auto sizes = [&](std::int64_t layers, std::int64_t bits) {
    std::string values(16, '\0');
    std::memcpy(values.data(), &layers, 8);
    std::memcpy(values.data() + 8, &bits, 8);
    return with("rvq_info.npy", npy("<i8", "(2,)", values));
  };
  EXPECT_EQ(sizes(5, 6), "a.npz: scale: has 675 bytes instead of 563 for 150 Gaussians");
  EXPECT_EQ(sizes(7, 6), "a.npz: codebook_scale: has no tensor layers.6._codebook.embed");
  EXPECT_EQ(sizes(6, 7),
            "a.npz: codebook_scale: layers.0._codebook.embed has 192 values instead of 384");
  EXPECT_EQ(sizes(0, 6), "a.npz: rvq_info: 0 layers of 6 bits are not read");
  EXPECT_EQ(sizes(65, 6), "a.npz: rvq_info: 65 layers of 6 bits are not read");
  EXPECT_EQ(sizes(-1, 6), "a.npz: rvq_info: -1 layers of 6 bits are not read");
  EXPECT_EQ(sizes(6, 17), "a.npz: rvq_info: 6 layers of 17 bits are not read");
  EXPECT_EQ(with("rvq_info.npy", npy("<i8", "(1,)", std::string(8, '\1'))),
            "a.npz: rvq_info: has not two values");
}

TEST(CompactHostile, models_without_gaussians_or_arrays_are_refused) {
  const ChangedModel model;
  EXPECT_EQ(model.npz([](ZipEntries& e) {
    replace_entry(e, "xyz.npy", npy("<f2", "(0, 3)", ""));
    replace_entry(e, "opacity.npy", npy("<f2", "(0, 1)", ""));
    replace_entry(e, "scale.npy", npy("|u1", "(0,)", ""));
    replace_entry(e, "rotation.npy", npy("|u1", "(0,)", ""));
  }),
            "a.npz: holds no Gaussians");
  for (const char* name : {"opacity", "scale", "rotation", "hash", "mlp", "codebook_scale",
                           "codebook_rotation", "rvq_info"}) {
    EXPECT_EQ(model.npz([&](ZipEntries& e) { erase_entry(e, std::string(name) + ".npy"); }),
              std::string("a.npz: the archive has no file ") + name + ".npy");
  }
  EXPECT_EQ(model.npz([](ZipEntries& e) { erase_entry(e, "xyz.npy"); }),
            "a.npz: a zip archive without xyz.npy");
  for (const char* name : {"minmax_opacity", "minmax_hash", "huftable_scale"}) {
    EXPECT_EQ(model.processed([&](ZipEntries& e) { erase_entry(e, std::string(name) + ".npy"); }),
              std::string("a.npz: the archive has no file ") + name + ".npy");
  }
}

TEST(CompactHostile, codebooks_that_are_none_are_refused) {
  const ChangedModel model;
  const auto with = [&](const std::string& pickle) {
    return model.npz(
        [&](ZipEntries& e) { replace_entry(e, "codebook_scale.npy", npy("|O", "()", pickle)); });
  };
  const std::string p = "a.npz: codebook_scale: its pickle: ";
  EXPECT_EQ(with("cos\nsystem\n\x8c\4true\x85R."),
            p + "the name os.system is not needed by any model and was refused");
  EXPECT_EQ(with("cposix\nsystem\n."),
            p + "the name posix.system is not needed by any model and was refused");
  EXPECT_EQ(with("ctorch\nload\n."),
            p + "the name torch.load is not needed by any model and was refused");
  EXPECT_EQ(with("N."), p + "the object is no array");
  const std::string array = "cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\n" +
                            std::string("K\0\x85", 3) + "C\1b\x87R";
  EXPECT_EQ(with(array + "."), p + "the state of an array is None instead of a tuple");
  EXPECT_EQ(with(array + "(K\1)NN]tb."), p + "the array has not one item");
  EXPECT_EQ(with(array + "(K\1)NN]NaNtb."), p + "the state of an array has 6 items instead of 5");
  EXPECT_EQ(with(array + "(K\1)NN]Natb."),
            "a.npz: codebook_scale: has no tensor layers.0._codebook.embed");
  EXPECT_EQ(with(array + "(K\1)NN]}\x8c\x18layers.0._codebook.embedNsatb."),
            p + "layers.0._codebook.embed is None instead of a result of "
                "torch._utils._rebuild_tensor_v2");
  // A tensor whose values are a pickle that holds another pickle, and so on.
  const std::string tensor = "ctorch._utils\n_rebuild_tensor_v2\n(";
  const std::string end = std::string("K\0", 2) + "K\1\x85K\1\x85\x89)tR";
  EXPECT_EQ(with(array + "(K\1)NN]}\x8c\x18layers.0._codebook.embed" + tensor +
                 "ctorch.storage\n_load_from_bytes\nC\3N.N\x85R" + end + "satb."),
            "a.npz: codebook_scale: not a file of PyTorch");
  EXPECT_EQ(with(array + "(K\1)NN]}\x8c\x18layers.0._codebook.embed" + tensor +
                 "ctorch.storage\n_load_from_bytes\nC\1c\x85R" + end + "satb."),
            p + "a name is cut off");
  EXPECT_EQ(with(array + "(K\1)NN]}\x8c\x18layers.0._codebook.embed" + tensor +
                 "ctorch.storage\n_load_from_bytes\nN\x85R" + end + "satb."),
            p + "the values of a storage are not bytes");
}

TEST(CompactHostile, tables_that_do_not_decode_are_refused) {
  const ChangedModel model;
  const std::string array = "cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\n" +
                            std::string("K\0\x85", 3) + "C\1b\x87R(K\1)NN]}";
  const std::string finish = "atb.";
  const auto with_table = [&](const std::string& items) {
    return model.processed([&](ZipEntries& e) {
      replace_entry(e, "huftable_scale.npy", npy("|O", "()", array + "(" + items + "u" + finish));
    });
  };
  EXPECT_EQ(with_table(""), "a.npz: scale: its table is empty");
  EXPECT_EQ(with_table("K\1K\1K\1\x86K\2K\1K\1\x86"),
            "a.npz: scale: a code of its table is the beginning of another one");
  EXPECT_EQ(with_table("K\1K\1K\5\x86"), "a.npz: scale: its table has the code 5 of 1 bits");
  EXPECT_THAT(with_table("K\1K\1K\1\x86"),
              AnyOf(HasSubstr("not in its table"), HasSubstr("symbols")));
  EXPECT_EQ(with_table("K\1K\1K\1\x86K\2K\1" + std::string("K\0", 2) + "\x86"),
            "a.npz: scale: has more than 900 symbols");
  // Codes from 64 on are in no codebook.
  EXPECT_EQ(model.processed([&](ZipEntries& e) {
    replace_entry(e, "huftable_scale.npy",
                  npy("|O", "()",
                      array + "(K\1K\1K\1\x86K\x40K\2" + std::string("K\0", 2) +
                          "\x86"
                          "cdahuffman.huffmancodec\n_EndOfFileSymbol\n)\x81K\2K\1\x86u" +
                          finish));
    replace_entry(e, "scale.npy", npy("|u1", "(113,)", std::string(112, '\xff') + '\xe2'));
  }),
            "a.npz: scale: code 64 is not in the codebook of 64");
  const auto with_stream = [&](const std::string& stream) {
    return model.processed([&](ZipEntries& e) {
      replace_entry(e, "opacity.npy",
                    npy("|u1", "(" + std::to_string(stream.size()) + ",)", stream));
    });
  };
  EXPECT_EQ(with_stream(""), "a.npz: opacity: has 0 symbols instead of 150");
  EXPECT_THAT(with_stream(std::string(500, '\x55')),
              AnyOf(HasSubstr("has more than 150 symbols"), HasSubstr("bytes follow")));
}

TEST(CompactHostile, networks_that_are_none_are_refused) {
  const ChangedModel model;
  const auto with = [&](const std::string& pickle) {
    return model.pth([&](ZipEntries& e) { replace_entry(e, "compact_small/data.pkl", pickle); });
  };
  EXPECT_EQ(with("}."), "a.pth: has no tensor 0.params");
  EXPECT_EQ(with("}\x8c\x08"
                 "0.paramsNs."),
            "a.pth: its pickle: 0.params is None instead of a result of "
            "torch._utils._rebuild_tensor_v2");
  EXPECT_EQ(with("cbuiltins\nexec\n."),
            "a.pth: its pickle: the name builtins.exec is not needed by any model and was refused");
  EXPECT_EQ(model.pth([](ZipEntries& e) { entry(e, "compact_small/data/1").resize(100); }),
            "a.pth: cut off: storage 1 has 100 bytes instead of 32768");
  EXPECT_EQ(model.pth([](ZipEntries& e) { erase_entry(e, "compact_small/data/0"); }),
            "a.pth: the archive has no file compact_small/data/0");
  EXPECT_EQ(model.pth([](ZipEntries& e) { e.emplace_back("other/data.pkl", "N."); }),
            "a.pth: a zip archive with 2 files data.pkl");
}

TEST(CompactHostile, zip_bombs_are_refused) {
  const ChangedModel model;
  const std::string large(200u << 20, '\0');
  EXPECT_EQ(model.npz([&](ZipEntries& e) {
    replace_entry(e, "hash.npy", npy("<f2", "(104857600,)", large));
  }),
            "a.npz: its files have more bytes unpacked than make sense in such a small archive");
  EXPECT_EQ(model.npz([&](ZipEntries& e) {
    replace_entry(e, "codebook_scale.npy", npy("|O", "()", large));
  }),
            "a.npz: codebook_scale.npy has 209715328 bytes unpacked, more than the 67108864 that "
            "make sense");
  EXPECT_EQ(
      model.pth([&](ZipEntries& e) { replace_entry(e, "compact_small/data.pkl", large); }),
      "a.pth: compact_small/data.pkl has 209715200 bytes unpacked, more than the 16777216 that "
      "make sense");
}

TEST(CompactHostile, values_that_cannot_be_drawn_are_dropped) {
  const ChangedModel model;
  EXPECT_EQ(model.npz([](ZipEntries& e) {
    std::string& xyz = entry(e, "xyz.npy");
    xyz[xyz.size() - 1] = '\x7c';  // the last half becomes infinite or NaN
    xyz[xyz.size() - 2] = 0;
    std::string& hash = entry(e, "hash.npy");
    for (std::size_t i = hash.size() - 4096; i < hash.size(); i += 2) hash[i + 1] = '\x7c';
  }),
            "");
}

TEST(CompactHostile, every_changed_header_byte_gives_a_scene_or_one_sentence) {
  const ChangedModel model;
  for (const char* name : {"xyz.npy", "scale.npy", "codebook_scale.npy", "huftable_hash.npy"}) {
    for (std::size_t at = 0; at < 700; at += at < 150 ? 3 : 29) {
      SCOPED_TRACE(std::string(name) + " at " + std::to_string(at));
      const std::string sentence = model.processed([&](ZipEntries& e) {
        std::string& content = entry(e, name);
        if (at < content.size()) content[at] = static_cast<char>(content[at] ^ 0x41);
      });
      EXPECT_THAT(sentence, AnyOf("", StartsWith("a.npz: ")));
    }
  }
}

}  // namespace
}  // namespace qs::test
