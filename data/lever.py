# A hub and an arm with fillets between them: every rim of the three is kept, also where a fillet ends on it.

units("mm")

hub = cylinder(0.4, height=0.6).name("hub")
arm = box(lo=(0, -0.15, -0.15), hi=(1.6, 0.15, 0.15)).name("arm")
tip = cylinder(0.3, at=(1.6, 0, 0), height=0.5).name("tip")

bore = cylinder(0.2).name("bore")
pin = cylinder(0.15, at=(1.6, 0, 0)).name("pin")

rooted = blend(hub, arm, 0.08).name("root")
whole = blend(rooted, tip, 0.08).name("neck")

part(whole - (bore | pin))
