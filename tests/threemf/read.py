"""Opens a 3MF file with lib3mf, strictly, tells what is in it, and writes it anew: read.py IN OUT."""

import json
import sys

import lib3mf

model = lib3mf.get_wrapper().CreateModel()
reader = model.QueryReader("3mf")
reader.SetStrictModeActive(True)
reader.ReadFromFile(sys.argv[1])


def each(iterator, current):
    while iterator.MoveNext():
        yield getattr(iterator, current)()


told = {
    "warnings": [reader.GetWarning(i) for i in range(reader.GetWarningCount())],
    "unit": model.GetUnit().name,
    "items": sum(1 for _ in each(model.GetBuildItems(), "GetCurrent")),
    "levelsets": [
        {
            "name": one.GetName(),
            "channel": one.GetChannelName(),
            "box": bool(one.GetMeshBBoxOnly()),
            "function": one.GetFunction().GetDisplayName(),
        }
        for one in each(model.GetLevelSets(), "GetCurrentLevelSet")
    ],
    "meshes": [
        {"name": one.GetName(), "triangles": one.GetTriangleCount(), "vertices": one.GetVertexCount(),
         "closed": bool(one.IsManifoldAndOriented())}
        for one in each(model.GetMeshObjects(), "GetCurrentMeshObject")
    ],
    "materials": [
        group.GetName(i)
        for group in each(model.GetBaseMaterialGroups(), "GetCurrentBaseMaterialGroup")
        for i in group.GetAllPropertyIDs()
    ],
}
model.QueryWriter("3mf").WriteToFile(sys.argv[2])
print(json.dumps(told))
