"""Design of a skin: resolution of a layout before it is made."""

from skinfield.design.design import Places as Places
from skinfield.design.design import SkinDesign as SkinDesign
from skinfield.design.design import Touch as Touch
from skinfield.design.detectability import BlindSpots as BlindSpots
from skinfield.design.detectability import DetectableForce as DetectableForce
from skinfield.design.detectability import Hole as Hole
from skinfield.design.detectability import blind_spots as blind_spots
from skinfield.design.detectability import detectable_force as detectable_force
from skinfield.design.discrimination import PlaceAccuracy as PlaceAccuracy
from skinfield.design.discrimination import TwoPointDistance as TwoPointDistance
from skinfield.design.discrimination import few_places as few_places
from skinfield.design.discrimination import place_accuracy as place_accuracy
from skinfield.design.discrimination import two_point_distance as two_point_distance
from skinfield.design.judgement import Judgement as Judgement
from skinfield.design.judgement import judge as judge
