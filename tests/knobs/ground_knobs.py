"""Parameters of a track on a ground -> (change of tests/knobs/on_ground.toml, context)."""
KNOBS = {
    "footing.before": ("footing.before=6", []),
    "footing.count": ("footing.count=5", []),
    "footing.first": ("footing.first=0.6", []),
    "footing.width": ("footing.width=0.3", []),
    "footing.length": ("footing.length=1.2", []),
    "footing.y": ("footing.y=0.8", []),
    "footing.rails": ("footing.rails=0.5", []),
    "track.zone.[].footprint": ("track.zone=[{from=4.7,to=6.1,footprint=0.8}]", []),
}
