"""Robots' XML as robotology/robots-configuration has it, small."""

DOCTYPE = (
    '<?xml version="1.0" encoding="UTF-8" ?>\n'
    '<!DOCTYPE {0} PUBLIC "-//YARP//DTD yarprobotinterface 3.0//EN" '
    '"http://www.yarp.it/DTD/yarprobotinterfaceV3.0.dtd">\n'
)
DEVICES, PARAMS = DOCTYPE.format("devices"), DOCTYPE.format("params")
SKIN = f"""{DEVICES}
    <device xmlns:xi="http://www.w3.org/2001/XInclude" name="left_leg-eb10-skin" type="embObjSkin">
        <xi:include href="../../general.xml" />
        <group name="patches">
            <param name="skinCanAddrsPatch1"> 1 2 3 </param>
            <param name="skinCanAddrsPatch2"> 13 0xC </param>
        </group>
        <xi:include href="./left_leg-eb10-skinSpec.xml" />
    </device>
"""
SPEC = f"""{PARAMS}
<params xmlns:xi="http://www.w3.org/2001/XInclude" robot="someone" build="1">
        <group name="defaultCfgBoard">
            <param name="period">        50  </param>
            <param name="skinType">      0  </param> <!-- 0 ==> new skin
                                                              1 ==> palm <!-- and -- fingertips -->
            <param name="noLoad">         0xf0  </param>
            <param name="diagnostic">    true  </param>     <!-- used to config high level -->
        </group>
        <group name="specialCfgBoards">
            <param name="numOfSets"> 1 </param>
            <param name="boardSetCfg1">  2           12          13       20    8    235 </param>
        </group>
        <group name="defaultCfgTriangle">
            <param name="enabled">         false  </param>
            <param name="shift">           2  </param>
            <param name="cdcOffset">       0x2200  </param>
        </group>
        <group name="specialCfgTriangles">
            <param name="numOfSets">  2  </param>
            <param name="triangleSetCfg1"> 1   3   0   3   1   2   0x2200 </param>
            <param name="triangleSetCfg2"> 2   13  5   5   true   0   0x2000 </param>
        </group>
</params>
"""
WRAPPER = f"""{DEVICES}
    <device xmlns:xi="http://www.w3.org/2001/XInclude" name="left_leg-wrapper" type="skinWrapper">
        <param name="period">       20                  </param>
        <param name="total_taxels"> 960                </param>
        <paramlist name="ports">
          <elem name="left_leg_upper">   384 959   0 575</elem>
          <!-- <elem name="left_leg_lower">  0 1 0 1</elem> -->
          <elem name="left_foot">    ( 0 383  0 383 )</elem>
        </paramlist>
        <action phase="startup" level="5" type="attach">
            <paramlist name="networks">
                <elem name="FirstSetOfSkins">  left_leg-eb10-skin </elem>
            </paramlist>
        </action>
    </device>
"""
OLD_SKIN = f"""{DEVICES}
  <device xmlns:xi="http://www.w3.org/2001/XInclude" name="fingertip" type="canBusSkin">
      <params robot="someone" build="1">
        <param name="canbusDevice"> "socketcan" </param>
        <param name="canDeviceNum"> 7 </param>
        <param name="skinCanIds"> 14 10 </param>
        <param name="period"> 10 </param>
      </params>
  </device>
"""
